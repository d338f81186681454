"""The digest of a run: SHA-256 over its ticks, in the layout that docs/reference/summary.md gives.

The state of a hash cannot be stored. Instead a copy of its input is written to a file, from which a resumed run
computes the hash again. The stored text of the hash shows whether that file is unchanged.
"""

import hashlib
import os
from pathlib import Path
from typing import BinaryIO

import numpy as np

from fes.arrays.types import Floats
from fes.errors import FesError
from fes.recording import hashed_file

_BLOCK = 1 << 20  # bytes


class Digest:
    """SHA-256 over ticks; call `add` once per tick, in order."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self._input: BinaryIO | None = None
        """Copy of the hashed bytes, if it is recorded."""
        self.length = 0
        """Number of bytes hashed."""
        self._stored = ""
        """Text of the hash at the checkpoint, to compare with the recorded input."""

    def add(self, tick: int, poses: Floats, twists: Floats) -> None:
        """Add a tick: poses [n, 3] and twists [n, 2]."""
        rows = np.empty((len(poses), 5), "<f8")
        rows[:, :3], rows[:, 3:] = poses, twists
        block = tick.to_bytes(8, "little", signed=True) + rows.tobytes()
        self._hash.update(block)
        self.length += len(block)
        if self._input is not None:
            self._input.write(block)

    def text(self) -> str:
        """Digest of the ticks so far, in hexadecimal."""
        return self._hash.hexdigest()

    def record_input(self, path: Path) -> BinaryIO:
        """Record all input in a new file, and return the file; call it before the first `add`."""
        self._input = open(path, "xb", opener=hashed_file.append)  # noqa: SIM115
        return self._input

    def check_input(self, path: Path) -> None:
        """Raise FesError unless the first `length` bytes of a recorded input are those that were hashed."""
        self._read(path)

    def resume_input(self, path: Path) -> BinaryIO:
        """Hash the first `length` bytes of a recorded input, cut the rest, and record further input there.

        Raises FesError if the bytes differ from those that were hashed, OSError if they cannot be read.
        """
        self._hash = self._read(path)
        os.truncate(path, self.length)
        self._input = open(path, "ab")  # noqa: SIM115
        return self._input

    def _read(self, path: Path) -> "hashlib._Hash":
        """Hash of the first `length` bytes of a recorded input."""
        computed = hashlib.sha256()
        with path.open("rb") as file:
            for start in range(0, self.length, _BLOCK):
                computed.update(file.read(min(_BLOCK, self.length - start)))
            if file.tell() < self.length:
                raise FesError(
                    f"{path} is damaged at byte {file.tell():,}: it ends there, instead of at byte {self.length:,}"
                )
        if computed.hexdigest() != self._stored:
            raise FesError(f"{path} is damaged: the SHA-256 of its first {self.length:,} bytes differs")
        return computed

    def close(self) -> None:
        """Stop recording the input."""
        if self._input is not None:
            self._input.close()
            self._input = None

    def __getstate__(self) -> dict[str, int | str]:
        return {"length": self.length, "text": self.text()}

    def __setstate__(self, state: dict[str, int | str]) -> None:
        self.__init__()  # type: ignore[misc]
        self.length, self._stored = int(state["length"]), str(state["text"])
