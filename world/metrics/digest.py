"""The digest of a run: SHA-256 over its ticks, in the layout that the README gives.

The state of a hash cannot be kept. So its input can be left in a file, the trail, from which a resumed run computes
the hash again. The text of the hash is kept, and shows whether the trail is still the same.
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
    """Sums up ticks, in order."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self._trail: BinaryIO | None = None
        self.length = 0
        """Bytes that went into it."""
        self._kept = ""
        """Its text as it was kept, for comparison with the trail."""

    def add(self, tick: int, poses: Floats, twists: Floats) -> None:
        """Add a tick: poses [n, 3] and twists [n, 2]."""
        told = np.int64(tick).astype("<i8").tobytes()
        told += np.concatenate([poses, twists], axis=1).astype("<f8", copy=False).tobytes()
        self._hash.update(told)
        self.length += len(told)
        if self._trail is not None:
            self._trail.write(told)

    def text(self) -> str:
        """Of the ticks so far, in hexadecimal."""
        return self._hash.hexdigest()

    def leave_in(self, path: Path) -> BinaryIO:
        """From now on leave a trail in a new file, which is returned; nothing may have been added yet."""
        self._trail = open(path, "xb", opener=hashed_file.append)  # noqa: SIM115
        return self._trail

    def check(self, path: Path) -> None:
        """Raise FesError unless the first `length` bytes of the trail in a file are those that were hashed."""
        self._read(path)

    def take_up(self, path: Path) -> BinaryIO:
        """Go on with the first `length` bytes of the trail in a file, and leave the rest of it there.

        Raises FesError if they differ, and OSError if they cannot be read.
        """
        self._hash = self._read(path)
        os.truncate(path, self.length)
        self._trail = open(path, "ab")  # noqa: SIM115
        return self._trail

    def _read(self, path: Path) -> "hashlib._Hash":
        found = hashlib.sha256()
        with path.open("rb") as file:
            for start in range(0, self.length, _BLOCK):
                found.update(file.read(min(_BLOCK, self.length - start)))
            if file.tell() < self.length:
                raise FesError(f"{path} is damaged at byte {file.tell():,}: it ends there, of {self.length:,}")
        if found.hexdigest() != self._kept:
            raise FesError(f"{path} is damaged: the SHA-256 of its first {self.length:,} bytes differs")
        return found

    def close(self) -> None:
        """Leave no trail any more."""
        if self._trail is not None:
            self._trail.close()
            self._trail = None

    def __getstate__(self) -> dict[str, int | str]:
        return {"length": self.length, "text": self.text()}

    def __setstate__(self, kept: dict[str, int | str]) -> None:
        self.__init__()  # type: ignore[misc]
        self.length, self._kept = int(kept["length"]), str(kept["text"])
