"""Notes of a run, appended as they are made: what a checkpoint is gone on from.

A note is handed to the system at once, so it outlives this process however it ends. Each is framed by its length and
a checksum: the last one may be torn, and reading ends there.
"""

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgpack

from fes.errors import FesError, reason

_FRAME = struct.Struct("<II")  # length and CRC-32 of what follows


class Journal:
    """A file of notes, to append to; raises FesError where it cannot be written."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.failure: FesError | None = None
        """Why there are no more notes."""
        try:
            self._file = path.open("ab", buffering=0)
        except OSError as error:
            raise FesError(f"cannot write {path}: {reason(error)}") from None

    def add(self, note: list[Any]) -> None:
        """Append a note of numbers, text, bytes, and lists of them.

        After a note that could not be written there are no others: nobody would read behind a torn one.
        """
        if self.failure is not None:
            raise self.failure
        packed = msgpack.packb(note)
        framed = _FRAME.pack(len(packed), zlib.crc32(packed)) + packed
        try:
            if self._file.write(framed) == len(framed):
                return
            self.failure = FesError(f"cannot write {self.path}: there is no room")
        except OSError as error:
            self.failure = FesError(f"cannot write {self.path}: {reason(error)}")
        raise self.failure

    def close(self) -> None:
        """Write no more."""
        self._file.close()


def notes(path: Path) -> Iterator[list[Any]]:
    """The notes in a file, in order, up to the first that is torn; raises OSError where it cannot be read."""
    with path.open("rb") as file:
        while len(head := file.read(_FRAME.size)) == _FRAME.size:
            length, checksum = _FRAME.unpack(head)
            packed = file.read(length)
            if len(packed) < length or zlib.crc32(packed) != checksum:
                return
            yield msgpack.unpackb(packed)
