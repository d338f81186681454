"""Wheels of this clone with the compiled core, built by `deploy.wheels`, and interpreters that have them."""

import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

from deploy.wheels.platforms import ANY, PLATFORMS, SOURCE, ZIG
from tests.portability.downloads import ROOT, pip_of, run
from tests.portability.interpreters import Interpreter

FEW, ALL = ("linux-x86_64", "linux-aarch64"), (*PLATFORMS, ANY, SOURCE)
"""Names of what is built: of the machines that can run it here, or all."""


class Broken(Exception):
    """A wheel that cannot be built, or that breaks a rule; the text is the output."""


def build(folder: Path, names: tuple[str, ...]) -> dict[str, Path]:
    """Machine -> its wheel for Linux, built in a folder. Raises Broken, or Unavailable without hatchling or zig."""
    pip = pip_of(folder / "builder")
    run(pip, "install", "-q", "hatchling", ZIG)
    into = folder / "wheels"
    shutil.rmtree(into, ignore_errors=True)
    done = subprocess.run(
        [pip.with_name("python"), "-m", "deploy.wheels", "--into", into, *names], cwd=ROOT, check=False,
        env=os.environ | {"ZIG_GLOBAL_CACHE_DIR": str(folder / "zig")}, capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode != 0:
        raise Broken(done.stdout + done.stderr)
    return {PLATFORMS[name].machine: next(into.glob(f"*.{PLATFORMS[name].tags[-1]}.whl")) for name in FEW}


def installed(interpreter: Interpreter, wheel: Path, pip: Path, folder: Path) -> Interpreter:
    """The interpreter with the wheel instead of this clone, of which it has only the tests.

    Raises Unavailable if pip rejects the wheel.
    """
    tag = wheel.stem.split("-")[-1].split(".")[-1]
    place = folder / f"installed-{tag}"
    shutil.rmtree(place, ignore_errors=True)
    run(
        pip, "install", "-q", "--no-compile", "--no-deps", "--no-index", "--target", place / "packages", "--platform",
        tag, "--implementation", "py", "--only-binary=:all:", wheel,
    )  # fmt: skip
    (place / "clone").mkdir()
    (place / "clone" / "tests").symlink_to(ROOT / "tests")
    environment = dict(interpreter.environment)
    environment["PYTHONPATH"] = os.pathsep.join([str(place / "packages"), environment["PYTHONPATH"]])
    return replace(
        interpreter, name=f"wheel, {interpreter.name}", environment=tuple(environment.items()), folder=place / "clone"
    )
