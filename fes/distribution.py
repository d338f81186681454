"""The distribution that installs this project, and how a clone installs it.

`fes` on the Python Package Index is another project. Ours is not published there, so no text may tell a user to
install it by name: every command that installs something comes from this module and names a clone.
"""

from importlib import metadata

NAME = "fes-robots"
"""Name of the distribution; the import names are fes, agents, world and console."""


def version() -> str:
    """Version of the installed distribution, such as '0.2.0'; raises PackageNotFoundError if it is not installed."""
    return metadata.version(NAME)


def install(extra: str = "") -> str:
    """The command that installs this project, with an extra if one is named, from the folder of a clone.

    >>> install(), install("plot")
    ('pip install -e . (in a clone of fes)', "pip install -e '.[plot]' (in a clone of fes)")
    """
    target = f"'.[{extra}]'" if extra else "."
    return f"pip install -e {target} (in a clone of fes)"
