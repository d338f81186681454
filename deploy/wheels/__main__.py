"""Build the files of a release: `python -m deploy.wheels [--into FOLDER] [NAME ...]`, on Linux or macOS.

The names are linux-x86_64, linux-aarch64, macos-x86_64, macos-arm64, any (no compiled core) and source; by default
all. This Python needs hatchling and, for the first four, zig: `pip install hatchling 'ziglang==0.17.*'`.

Exit codes: 0 all files are built and keep the rules, 1 one is not or does not.
"""

import argparse
import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from deploy.wheels import contents
from deploy.wheels.platforms import ANY, PLATFORMS, SOURCE, ZIG

ROOT = Path(__file__).absolute().parents[2]


def environment(name: str) -> dict[str, str]:
    """The variables with which hatch_build.py builds a file."""
    if name not in PLATFORMS:
        return {"FES_CORE": "numpy"}
    platform = PLATFORMS[name]
    return {"FES_CORE": "c", "FES_PLATFORM": ".".join(platform.tags), "CC": platform.compiler(sys.executable)}


def build(name: str, into: Path) -> Path:
    """Build a file into a folder; returns its path. Raises CalledProcessError with the errors."""
    with tempfile.TemporaryDirectory(prefix="fes-wheels-", dir=into) as work:
        kind = "sdist" if name == SOURCE else "wheel"
        subprocess.run(
            [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", work],
            cwd=ROOT, env=os.environ | environment(name), capture_output=True, text=True, check=True,
        )  # fmt: skip
        [made] = [path for path in Path(work).iterdir() if path.suffix in (".whl", ".gz")]
        return made.replace(into / made.name)


def main() -> int:
    """Build and check; returns the exit code."""
    names = [*PLATFORMS, ANY, SOURCE]
    parser = argparse.ArgumentParser(prog="python -m deploy.wheels", description="the files of a release")
    parser.add_argument("name", nargs="*", metavar="NAME", help=f"by default all: {', '.join(names)}")
    parser.add_argument("--into", type=Path, default=ROOT / "dist", metavar="FOLDER", help="by default dist")
    given = parser.parse_args()
    if unknown := [name for name in given.name if name not in names]:
        parser.error(f"no file {unknown[0]}; the names are {', '.join(names)}")
    chosen = given.name or names
    wanted = {"hatchling": "hatchling"} | ({"ziglang": ZIG} if set(chosen) & set(PLATFORMS) else {})
    if missing := [name for module, name in wanted.items() if importlib.util.find_spec(module) is None]:
        parser.error(f"this Python lacks {' and '.join(missing)}: pip install {' '.join(map(repr, missing))}")
    into = given.into.absolute()
    into.mkdir(parents=True, exist_ok=True)
    failed = 0
    for name in chosen:
        try:
            path = build(name, into)
        except subprocess.CalledProcessError as error:
            failed = 1
            print(f"{name}: FAILED\n{error.stderr}", flush=True)
            continue
        found = contents.problems(path, name)
        failed = failed or int(bool(found))
        print(f"{name}: {path.name}", *(f"    FAILED: {problem}" for problem in found), sep="\n", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
