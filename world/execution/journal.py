"""The journal of a run: notes of every external input since a checkpoint.

A note is handed to the operating system at once, so it survives however this process ends. Its frame holds its
length, a checksum of the length, and a checksum of the note. Each checksum continues the one before it, from the
first note of the run on, through all its journals. So an altered, lost or moved note is detected anywhere.

An incomplete frame ends a journal: power loss or a full disk may cut the last note. A complete frame whose checksum
differs is damage, even in the last note: the operating system writes a file from front to end.
"""

import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import msgpack

from fes.errors import FesError, reason
from fes.recording import hashed_file

# Magic, number, the checksum that the notes continue, and the checksum of these three.
_HEAD = struct.Struct("<12sIII")
_FRAME = struct.Struct("<III")
_MAGIC = b"fes notes 3\n"


class Journal:
    """A new file of notes; raises FesError where it cannot be written."""

    def __init__(self, path: Path, number: int = 1, checksum: int = 0) -> None:
        """`number` counts the journals of a run; `checksum` is that of all notes before."""
        self.path = path
        self.failure: FesError | None = None
        """Reason why no more notes are written; None if they are."""
        self.checksum = checksum
        """Checksum of all notes so far."""
        self._size = 0
        try:
            self._file = open(path, "xb", buffering=0, opener=hashed_file.append)  # noqa: SIM115
        except OSError as error:
            raise FesError(f"cannot write {path}: {reason(error, with_file=False)}") from None
        head = _HEAD.pack(_MAGIC, number, checksum, 0)[:-4]
        self._write(head + zlib.crc32(head).to_bytes(4, "little"))

    def add(self, note: list[Any]) -> None:
        """Append a note of numbers, text, bytes, and lists of them.

        After a failed write no further note is written, because a reader stops at a torn note.
        """
        if self.failure is not None:
            raise self.failure
        packed = msgpack.packb(note)
        length = len(packed).to_bytes(4, "little")
        of_length = zlib.crc32(length, self.checksum)
        self.checksum = zlib.crc32(packed, of_length)
        self._write(_FRAME.pack(len(packed), of_length, self.checksum) + packed)

    def loss(self) -> str | None:
        """Damage of the file by other programs, in words; None if it is unchanged."""
        return hashed_file.loss(self.path, self._file.fileno(), self._size)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write(self, content: bytes) -> None:
        try:
            self._size += len(content)
            if self._file.write(content) == len(content):
                return
            self.failure = FesError(f"cannot write {self.path}: there is no room")
        except OSError as error:
            self.failure = FesError(f"cannot write {self.path}: {reason(error, with_file=False)}")
        raise self.failure


def notes(path: Path) -> Iterator[list[Any]]:
    """The notes in one journal, in order, up to a torn one; raises FesError if it is damaged."""
    with path.open("rb") as file:
        head = _read_head(path, file)
        if head is not None:
            yield from (note for _, note in _notes(path, file, head[1]))


def chained(paths: list[Path], number: int, checksum: int) -> Iterator[tuple[int, list[Any]]]:
    """The notes in the journals from `number` on, which continue `checksum`: pairs of the checksum so
    far and a note.

    Raises FesError if a journal is damaged or missing, and OSError if it cannot be read.
    """
    if not paths:
        raise FesError(f"journal {number} is missing")
    for expected, path in enumerate(paths, number):
        with path.open("rb") as file:
            head = _read_head(path, file)
            if head is None:
                continue
            if head != (expected, checksum):
                raise FesError(f"{path} is damaged: notes before it are missing, or it belongs to another run")
            for after, note in _notes(path, file, checksum):
                checksum = after
                yield checksum, note


def _read_head(path: Path, file: BinaryIO) -> tuple[int, int] | None:
    """The number of a journal, and the checksum that its notes continue; None if its head was cut."""
    head = file.read(_HEAD.size)
    if len(head) < _HEAD.size:
        return None
    magic, number, before, checksum = _HEAD.unpack(head)
    if magic != _MAGIC or checksum != zlib.crc32(head[:-4]):
        raise FesError(f"{path} is damaged at byte 0: its head differs")
    return number, before


def _notes(path: Path, file: BinaryIO, checksum: int) -> Iterator[tuple[int, list[Any]]]:
    """The notes of a file, each after the checksum that includes it."""
    place, size = _HEAD.size, os.fstat(file.fileno()).st_size
    while len(head := file.read(_FRAME.size)) == _FRAME.size:
        length, of_length, after = _FRAME.unpack(head)
        if zlib.crc32(head[:4], checksum) != of_length:
            raise FesError(f"{path} is damaged at byte {place:,}: the checksum of a length differs")
        if place + _FRAME.size + length > size:
            return
        packed = file.read(length)
        checksum = zlib.crc32(packed, of_length)
        if checksum != after:
            raise FesError(f"{path} is damaged at byte {place:,}: the checksum of a note differs")
        yield checksum, msgpack.unpackb(packed)
        place += _FRAME.size + length
