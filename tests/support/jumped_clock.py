"""A wall clock that jumps under processes that run: a C library that they load first, and the file that moves it."""

import mmap
import os
import shutil
import struct
import subprocess
from pathlib import Path

import pytest

SOURCE = Path(__file__).with_suffix(".c")
KINDS = ("gate", "table", "agent")
"""Kinds of processes, in the order of jumped_clock.c; `agent` includes the writer of its log."""

COMPILER = shutil.which(os.environ.get("CC", "cc"))

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="without a C compiler no clock can be moved")


class JumpedClock:
    """The wall clocks of the processes of one test."""

    def __init__(self, folder: Path) -> None:
        """Compile the library into `folder`; raises CalledProcessError."""
        library, path = folder / "jumped_clock.so", folder / "offsets"
        words = [str(COMPILER), "-shared", "-fPIC", "-O1", "-Wall", "-Werror", "-o", str(library), str(SOURCE)]
        subprocess.run(words, check=True)
        path.write_bytes(bytes(8 * len(KINDS)))
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), 0)
        self.environment = {"LD_PRELOAD": str(library), "FES_JUMPED_CLOCK": str(path)}
        """Variables of the processes whose clocks it moves."""

    def jump(self, seconds: int, *kinds: str) -> None:
        """Move the wall clocks of these kinds of processes by `seconds` from the truth."""
        for kind in kinds:
            struct.pack_into("<q", self._map, 8 * KINDS.index(kind), seconds)
