"""Built-in scenarios: the folder configs/ of a clone, which an installed wheel carries as world/scenarios/."""

import difflib
from pathlib import Path

from fes.errors import ScenarioError

_INSTALLED = Path(__file__).absolute().parents[1] / "scenarios"
FOLDER = _INSTALLED if _INSTALLED.is_dir() else Path(__file__).absolute().parents[2] / "configs"
"""Folder of the built-in scenarios."""

ARGUMENT = "a scenario file, or the name of a built-in scenario (fes run --help lists them)"
"""Help text of a SCENARIO argument."""

SIMILAR = 0.5
"""Least similarity, from 0 to 1, of a name that an error suggests."""


def names() -> list[str]:
    """The names of the built-in scenarios, such as paper and faults/death; those in sub-folders last."""
    relative = [path.relative_to(FOLDER).with_suffix("") for path in FOLDER.rglob("*.toml")]
    return [path.as_posix() for path in sorted(relative, key=lambda path: (len(path.parts), path))]


def file_of(name: str) -> Path:
    """The file of the built-in scenario `name`."""
    return FOLDER / f"{name}.toml"


def resolve(scenario: Path) -> Path:
    """The file of a SCENARIO argument: an existing file, or else the built-in scenario of that name.

    Raises ScenarioError if it is neither.
    """
    try:
        is_folder, exists = scenario.is_dir(), scenario.exists()
    except (OSError, ValueError):
        return scenario  # the function that opens it reports the error
    known = names()
    if (is_folder or not exists) and scenario.as_posix() in known:
        return file_of(scenario.as_posix())
    if exists:
        return scenario
    near = difflib.get_close_matches(scenario.with_suffix("").as_posix(), known, 1, SIMILAR)
    near = near or difflib.get_close_matches(scenario.stem, known, 1, SIMILAR)
    suggestion = f"the nearest is '{near[0]}', and " if near else ""
    unknown = "No such file, and not the name of a built-in scenario"
    raise ScenarioError(str(scenario), f"{unknown}: {suggestion}fes run --help lists all of them")


def completions(incomplete: str) -> list[str]:
    """The names of built-in scenarios that start with `incomplete`, for a shell."""
    return [name for name in names() if name.startswith(incomplete)]
