"""Pythons that can run a module of this project: this one, another of the machine, and unpacked ones of Debian."""

import os
import platform
import re
import shutil
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

from tests.portability import downloads
from tests.portability.downloads import MACHINES, ROOT, Unavailable

OLDEST = 11
"""Minor version of the oldest Python 3 that the project allows."""

EMULATOR = "qemu-aarch64-static"
BASE = ("python3-minimal", "libpython3-stdlib", "libstdc++6", "tzdata")

STOPPED = 130
"""Exit code of a program that was not started, because this one was told to stop."""

_children: list["subprocess.Popen[bytes]"] = []
_stopped = threading.Event()


def is_stopped() -> bool:
    """True after `stop`."""
    return _stopped.is_set()


def stop() -> None:
    """End all programs, and start no more."""
    _stopped.set()
    for child in list(_children):
        child.kill()


@dataclass(frozen=True)
class Interpreter:
    """A Python with the project's dependencies."""

    name: str
    words: tuple[str, ...]
    """The beginning of its command lines."""
    environment: tuple[tuple[str, str], ...]
    folder: Path = ROOT
    """The folder in which it runs, whose modules come before all others."""

    def run(self, output: Path, *words: str, **environment: str) -> int:
        """Run `python WORDS` to its end, in its folder; its output goes to a file. Returns its exit code."""
        names = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "VIRTUAL_ENV"))}
        with output.open("w") as file:
            if _stopped.is_set():
                return STOPPED
            child = subprocess.Popen(
                [*self.words, *words], cwd=self.folder, env=names | dict(self.environment) | environment, stdout=file,
                stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            )  # fmt: skip
        _children.append(child)
        if _stopped.is_set():  # between the start and the line above
            child.kill()
        return child.wait()

    def says(self, code: str) -> str:
        """Output of a program of one line."""
        return downloads.run(*self.words, "-c", code, **dict(self.environment)).strip()


class Workshop:
    """Makes interpreters; their files lie in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.pip = downloads.pip_of(folder / "pip")
        self.machine = platform.machine()

    def of(self, words: tuple[str, ...], name: str, minor: str, machine: str, oldest: bool = False) -> Interpreter:
        """The interpreter that `words` start, with wheels of its own."""
        label = f"libraries-{machine}-{minor}-{'oldest' if oldest else 'newest'}"
        place = downloads.libraries(self.folder / label, self.pip, minor, machine, oldest)
        paths = {"PYTHONPATH": str(place), "PYTHONPYCACHEPREFIX": str(self.folder / "bytecode")}
        return Interpreter(name, words, tuple(paths.items()))

    def own(self, oldest: bool = False) -> Interpreter:
        """This Python, with the newest libraries, or with the oldest numpy."""
        minor = f"3.{sys.version_info.minor}"
        return self.of((sys.executable,), "own", minor, self.machine, oldest)

    def others(self) -> list[Interpreter]:
        """Other Pythons of this machine, one of each minor version, the newest first."""
        found = self._found()
        return [
            self.of((str(found[minor]),), f"python-3.{minor}", f"3.{minor}", self.machine)
            for minor in sorted(found, reverse=True)
        ]

    @staticmethod
    def _found() -> dict[int, Path]:
        """Minor version -> program."""
        found: dict[int, Path] = {}
        folders = [Path(folder) for folder in os.get_exec_path()]
        folders += sorted(Path.home().glob(".pyenv/versions/3.*/bin"))
        for path in (path for folder in folders for path in folder.glob("python3.*")):
            minor = int(match[1]) if (match := re.fullmatch(r"python3\.(\d+)", path.name)) else 0
            if minor >= OLDEST and minor != sys.version_info.minor and minor not in found and _runs(path):
                found[minor] = path
        return found

    @property
    def has_others(self) -> bool:
        """True if this machine has another Python."""
        return bool(self._found())

    def of_next_debian(self) -> Interpreter:
        """The Python 3.13 of Debian 13, with its C library, started by its own loader."""
        top = downloads.packages(self.folder / "trixie", "trixie", "amd64", *BASE)
        if self.machine != "x86_64":
            raise Unavailable(f"it is made for x86_64, and this is {self.machine}")
        paths = f"{top}/usr/lib/x86_64-linux-gnu:{top}/usr/lib"
        loader = next(iter(sorted(top.glob("usr/lib*/ld-linux-x86-64.so.2"))), None)
        if loader is None:
            raise Unavailable("its packages hold no loader")
        python = str(top / "usr/bin/python3.13")
        words = (str(loader), "--library-path", paths, "--argv0", python, python)
        made = self.of(words, "debian-13", "3.13", self.machine)
        return Interpreter(made.name, words, (*made.environment, ("PYTHONHOME", f"{top}/usr")))

    def emulated(self, suite: str = "bookworm", minor: str = "3.11") -> Interpreter:
        """A Python of Debian for aarch64, emulated by qemu."""
        qemu = shutil.which(EMULATOR)
        if qemu is None:
            host = {of_wheels: of_debian for of_debian, of_wheels in MACHINES.items()}.get(self.machine)
            if host is None:
                raise Unavailable(f"no {EMULATOR} is known for {self.machine}")
            place = downloads.packages(self.folder / "qemu", "bookworm", host, "qemu-user-static", alone=True)
            qemu = str(place / "usr" / "bin" / EMULATOR)
        top = downloads.packages(self.folder / f"{suite}-arm64", suite, "arm64", *BASE)
        words = (qemu, "-L", str(top), str(top / "usr" / "bin" / f"python{minor}"))
        return self.of(words, f"aarch64-{suite}", minor, "aarch64")


def _runs(python: Path) -> bool:
    """True if a file is a Python that starts: a shim of a version manager may not."""
    try:
        done = subprocess.run([python, "-c", "import ssl, sqlite3"], capture_output=True, check=False, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0
