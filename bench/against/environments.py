"""Virtual environments of other programs: an earlier commit of this repository, and VMAS from PyPI.

Each is made once in a folder and used again while its requirements are the same.
"""

import json
import os
import shutil
import subprocess
import sys
import tarfile
from importlib.metadata import version
from io import BytesIO
from pathlib import Path

from bench.against.programs import NotMeasured, output

OLD = "85d335e"
"""The commit that rates are compared with."""

VMAS = "vmas==1.5.2"

SHARED = ("numpy", "eclipse-zenoh")
"""Packages of which the earlier commit gets the versions of this process, so that only fes differs."""

_READY = "ready.json"
"""File that lists the requirements of a finished environment."""

ISOLATED = {"PYTHONPATH": None, "PYTHONHOME": None, "VIRTUAL_ENV": None}
"""Variables that would show another program the modules of this one."""


def default_folder() -> Path:
    """The user's cache directory for this harness."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fes-bench"


def tree(folder: Path) -> Path:
    """The folder of the earlier commit's files."""
    return folder / OLD / "tree"


def old(folder: Path) -> Path:
    """The Python of the earlier commit's environment, made if necessary."""
    requirements = [f"{name}=={version(name)}" for name in SHARED]
    place = folder / OLD
    if not _is_ready(place, requirements):
        shutil.rmtree(place, ignore_errors=True)
        _export(OLD, tree(folder))
        _install(place, [str(tree(folder)), *requirements])
        _finish(place, requirements)
    return _python(place)


def vmas(folder: Path) -> Path:
    """The Python of an environment with VMAS and torch, made if necessary: a download of up to 3 GB."""
    place = folder / VMAS.replace("==", "-")
    if not _is_ready(place, [VMAS]):
        shutil.rmtree(place, ignore_errors=True)
        _install(place, [VMAS])
        _finish(place, [VMAS])
    return _python(place)


def _export(commit: str, place: Path) -> None:
    """Write the files of a commit of the repository that this module is in."""
    repository = Path(__file__).resolve().parents[2]
    words = ["git", "-C", str(repository), "archive", "--format=tar", commit]
    try:
        archive = subprocess.run(words, capture_output=True, check=True).stdout
    except OSError as error:
        raise NotMeasured(f"git does not run: {error}") from error
    except subprocess.CalledProcessError as error:
        raise NotMeasured(f"the repository lacks commit {commit}: {error.stderr.decode().strip()}") from error
    place.mkdir(parents=True)
    with tarfile.open(fileobj=BytesIO(archive)) as packed:
        packed.extractall(place, filter="data")


def _install(place: Path, requirements: list[str]) -> None:
    print(f"makes {place} with {', '.join(requirements)}", flush=True)
    output([sys.executable, "-m", "venv", place / "venv"], ISOLATED)
    output([_python(place), "-m", "pip", "install", "-q", *requirements], ISOLATED)


def _python(place: Path) -> Path:
    return place / "venv" / "bin" / "python"


def _contents(requirements: list[str]) -> list[str]:
    return [sys.version, *requirements]


def _is_ready(place: Path, requirements: list[str]) -> bool:
    """True if the environment is finished, and made for this Python and these requirements."""
    try:
        stored: object = json.loads((place / _READY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return stored == _contents(requirements)


def _finish(place: Path, requirements: list[str]) -> None:
    (place / _READY).write_text(json.dumps(_contents(requirements)), encoding="utf-8")
