"""The distribution that installs this project: its name, its packages, and how a clone installs it.

`fes` on the Python Package Index is another project. Ours is not published there, so no text may tell a user to
install it by name: every command that installs something comes from this module and names a clone.

`fes_robots.py` loads this file before it knows whether the package `fes` is ours. So this file imports only the
standard library.
"""

import importlib.util
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

NAME = "fes-robots"
"""Name of the distribution; `PACKAGES` are its import names."""

STRANGER = "fes"
"""Name of a distribution that is not ours: another project's, or this one before version 0.2.0."""

PACKAGES = ("fes", "agents", "world", "field", "console")
"""Top-level packages of the distribution, beside the module fes_robots."""

HOME = Path(__file__).absolute().parents[2]
"""Folder of our packages: site-packages, or a clone."""


def absence() -> str:
    """Complaint that this project is not installed for this Python, in one line; empty if it is.

    A clone that was updated but not installed again has the packages, and maybe commands, under an older name.
    """
    try:
        metadata.version(NAME)
    except metadata.PackageNotFoundError:
        return f"{NAME} is not installed here: {install()}"
    return ""


def install(extra: str = "") -> str:
    """The command that installs this project, with an extra if one is named, from the folder of a clone.

    >>> install(), install("plot")
    ('pip install -e .  # in a clone of fes', "pip install -e '.[plot]'  # in a clone of fes")
    """
    target = f"'.[{extra}]'" if extra else "."
    return f"pip install -e {target}  # in a clone of fes"


def separate() -> str:
    """The commands that install this project where no other package can conflict with it."""
    return f"use an environment of its own: python3 -m venv .venv && .venv/bin/{install()}"


def foreign() -> Iterator[str]:
    """Each package of ours that Python finds elsewhere: its name, and where it is instead."""
    for package in PACKAGES:
        try:
            spec = importlib.util.find_spec(package)
        except ValueError:  # it is imported, and has no spec
            spec = None
        origin = Path(spec.origin) if spec is not None and spec.origin else None
        if origin is None:
            yield f"the package '{package}' is missing beside those in {HOME}"
        elif not _is_same(origin, HOME / package / "__init__.py"):
            owners = metadata.packages_distributions().get(package, [])
            others = ", ".join(sorted(set(owners) - {NAME}))
            yield f"the package '{package}' is that of {others or 'another project'}: {origin}, not in {HOME}"


def _is_same(first: Path, second: Path) -> bool:
    """True if both paths lead to the same file, through any links."""
    try:
        return first.samefile(second)
    except OSError:
        return False
