"""The digest of a run: SHA-256 over its ticks, in the layout that the README gives.

The state of a hash cannot be kept. So what went into it can be left in a file, its trail, from which a run that is
gone on with takes it up again.
"""

import hashlib
from pathlib import Path
from typing import BinaryIO

import numpy as np

from fes.arrays import Floats

_BLOCK = 1 << 20  # bytes


class Digest:
    """Sums up ticks, in order."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self._trail: BinaryIO | None = None
        self.length = 0
        """Bytes that went into it."""

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
        self._trail = path.open("wb")
        return self._trail

    def take_up(self, path: Path) -> BinaryIO:
        """Go on with the first `length` bytes of the trail in a file, and leave the rest of it there.

        Raises EOFError where it is shorter.
        """
        with path.open("rb") as file:
            for start in range(0, self.length, _BLOCK):
                self._hash.update(file.read(min(_BLOCK, self.length - start)))
            if file.tell() < self.length:
                raise EOFError(f"{path} holds {file.tell()} of {self.length} bytes")
        self._trail = path.open("r+b")
        self._trail.truncate(self.length)
        self._trail.seek(self.length)
        return self._trail

    def close(self) -> None:
        """Leave no trail any more."""
        if self._trail is not None:
            self._trail.close()
            self._trail = None

    def __getstate__(self) -> dict[str, int]:
        return {"length": self.length}

    def __setstate__(self, kept: dict[str, int]) -> None:
        self.__init__()  # type: ignore[misc]
        self.length = kept["length"]
