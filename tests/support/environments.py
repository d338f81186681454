"""Virtual environments, and wheels of projects to install there."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

from hatchling.build import build_wheel


def wheel_of(project: Path, folder: Path) -> Path:
    """The wheel of the project in a folder, built into another folder."""
    before = Path.cwd()
    os.chdir(project)
    try:
        return folder / build_wheel(str(folder))
    finally:
        os.chdir(before)


class Environment:
    """A virtual environment without fes, with the libraries of this one."""

    def __init__(self, folder: Path) -> None:
        venv.create(folder)
        self.programs = folder / "bin"
        self.packages = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder)}))
        (self.packages / "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n")

    def install(self, wheel: Path) -> None:
        """Install a wheel without its dependencies."""
        python = str(self.programs / "python")
        words = ["--python", python, "install", "-q", "--no-deps", "--no-index", "--disable-pip-version-check"]
        subprocess.run([sys.executable, "-m", "pip", *words, str(wheel)], check=True, timeout=120)

    def call(self, where: Path, *words: str) -> "subprocess.CompletedProcess[str]":
        """Outcome of one of its commands in the folder `where`."""
        return subprocess.run(
            [str(self.programs / words[0]), *words[1:]],
            cwd=where, env=_variables(), stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120,
        )  # fmt: skip

    def start(self, where: Path, *words: str) -> "subprocess.Popen[str]":
        """One of its commands, running in the folder `where`."""
        return subprocess.Popen(
            [str(self.programs / words[0]), *words[1:]],
            cwd=where, env=_variables(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip

    def names(self, where: Path) -> dict[str, str]:
        """The finding of its doctor on our names."""
        findings = json.loads(self.call(where, "fes", "doctor", "--json").stdout)
        [finding] = [finding for finding in findings if finding["check"] == "our names"]
        return finding  # type: ignore[no-any-return]


def _variables() -> dict[str, str]:
    """The environment variables of its commands: without a path to the clone."""
    locale = "PYTHONUTF8", "PYTHONCOERCECLOCALE"  # as for the tests, which decode its output
    return {key: value for key, value in os.environ.items() if key in locale or not key.startswith("PYTHON")}
