"""Virtual environments, and wheels of projects to install there."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Callable
from pathlib import Path

from hatchling.build import build_sdist, build_wheel


def wheel_of(project: Path, folder: Path) -> Path:
    """The wheel of the project in a folder, built into another folder."""
    return folder / _built(project, folder, build_wheel)


def source_of(project: Path, folder: Path) -> Path:
    """The source distribution of the project in a folder, built into another folder."""
    return folder / _built(project, folder, build_sdist)


def _built(project: Path, folder: Path, build: Callable[[str], str]) -> str:
    """The name of the file that `build` makes; it works in the current folder."""
    before = Path.cwd()
    os.chdir(project)
    try:
        return build(str(folder))
    finally:
        os.chdir(before)


class Environment:
    """A virtual environment without fes, with the libraries of this one."""

    def __init__(self, folder: Path) -> None:
        venv.create(folder)
        self.programs = folder / "bin"
        self.packages = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder)}))
        (self.packages / "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n")

    def install(self, file: Path, **variables: str) -> None:
        """Install a wheel or a source distribution without its dependencies."""
        words = ["--python", str(self.programs / "python"), "install", "-q", "--no-deps", "--no-index"]
        words += ["--no-build-isolation", "--disable-pip-version-check", str(file)]
        environment = {name: value for name, value in os.environ.items() if name not in ("CC", "FES_CORE")}
        subprocess.run([sys.executable, "-m", "pip", *words], env=environment | variables, check=True, timeout=300)

    def call(self, where: Path, *words: str, **variables: str) -> "subprocess.CompletedProcess[str]":
        """Outcome of one of its commands in the folder `where`, with further environment variables."""
        return subprocess.run(
            [str(self.programs / words[0]), *words[1:]],
            cwd=where, env=_variables() | variables, stdin=subprocess.DEVNULL, capture_output=True, text=True,
            timeout=120,
        )  # fmt: skip

    def start(self, where: Path, *words: str) -> "subprocess.Popen[str]":
        """One of its commands, running in the folder `where`."""
        return subprocess.Popen(
            [str(self.programs / words[0]), *words[1:]],
            cwd=where, env=_variables(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip

    def digest(self, where: Path, **variables: str) -> str:
        """The digest of `pair` in one loop, at its whole length."""
        words = ("run", "pair", "--backend", "inprocess", "--headless", "--json")
        return str(json.loads(self.call(where, "fes", *words, **variables).stdout)["digest"])

    def names(self, where: Path) -> dict[str, str]:
        """The finding of its doctor on our names."""
        return self.finding(where, "our names")

    def finding(self, where: Path, check: str) -> dict[str, str]:
        """The finding of its doctor in a check."""
        findings = json.loads(self.call(where, "fes", "doctor", "--json").stdout)
        [finding] = [finding for finding in findings if finding["check"] == check]
        return finding  # type: ignore[no-any-return]


def _variables() -> dict[str, str]:
    """The environment variables of its commands: without a path to the clone, or a choice of the core."""
    locale = "PYTHONUTF8", "PYTHONCOERCECLOCALE"  # as for the tests, which decode its output
    own = ("PYTHON", "FES_CORE")
    return {key: value for key, value in os.environ.items() if key in locale or not key.startswith(own)}
