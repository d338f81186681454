"""Records of an MCAP file, read in order: the only reader of logs, with bounds on what they may hold.

Every checksum must be present and correct: that of each chunk, of the data, and of the index at the end. mcap parses
the records. Their frames are read here, since mcap's readers trust every length, and a chunk may unpack to any size.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from fes.errors import FesError, reason
from fes.system import files

LIMIT = 1 << 26
"""Largest record, and largest unpacked chunk [bytes]."""

SMALL = 1 << 24
"""Largest record, other than a chunk, that is read into a table [bytes]."""

RATIO, FREE = 1000, 1 << 28
"""A file unpacks to at most RATIO times its size and FREE bytes. A run's log unpacks to 3 times its size; where
hundreds of robots are absent, to 80 times."""

_HEAD = struct.Struct("<BQ")  # opcode and length
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log and publish time

_TYPES: dict[int, Any] = {
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK: Chunk,
    Opcode.METADATA: Metadata,
}
"""Types of the records that are read here; an index is only verified."""

_BROKEN = (McapError, zstandard.ZstdError, struct.error, ValueError, KeyError, OverflowError, MemoryError)
"""Errors that mcap and zstandard raise for bytes that are not a record."""


class Damaged(FesError):
    """A file whose bytes are not those of a log."""

    def __init__(self, path: Path, place: int, why: str) -> None:
        super().__init__(f"{path} is damaged at byte {place:,}: {why}")


@dataclass(frozen=True, eq=False)
class Block:
    """A record of a file, and the records in it."""

    reader: "Reader"
    place: int
    """Offset at which it begins [bytes]."""
    record: McapRecord
    """The data of a chunk is unpacked."""

    def __iter__(self) -> Iterator[McapRecord]:
        """The schemas, channels and messages in a chunk, in order; else the record itself."""
        if isinstance(self.record, Chunk):
            return self.reader.within(self.record.data, self.place)
        return iter([self.record])


class Reader:
    """The records of one file; it can be iterated over once, and raises FesError."""

    def __init__(self, path: Path, size: int | None = None) -> None:
        """With a `size`, only the first `size` bytes are read, which must be whole records."""
        self.path = path
        self.has_end = False
        """True once the end of the log was read: no record can be missing."""
        self._size = size
        self._place = len(MCAP0_MAGIC)
        self._checksum = zlib.crc32(MCAP0_MAGIC)
        self._data_ended = False
        self._unpacked = 0
        self._channels: set[int] = set()

    def __iter__(self) -> Iterator[Block]:
        """The blocks of the file, in order; only the whole ones if the file was cut."""
        try:
            with files.opened(self.path) as file:
                if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                    raise FesError(f"{self.path} is not a log: it is not an MCAP file")
                yield from self._blocks(file)
        except OSError as error:
            raise FesError(f"{self.path} cannot be read: {reason(error, with_file=False)}") from None

    def within(self, data: bytes, place: int) -> Iterator[McapRecord]:
        """The records in the unpacked data of the chunk at `place`; raises Damaged."""
        start = 0
        while start < len(data):
            begin = start + _HEAD.size
            if begin > len(data):
                raise Damaged(self.path, place, "its chunk ends within a record")
            opcode, length = _HEAD.unpack_from(data, start)
            if begin + length > len(data):
                raise Damaged(self.path, place, "a record extends beyond its chunk")
            if opcode not in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
                raise Damaged(self.path, place, f"its chunk holds a record of kind {opcode}")
            start = begin + length
            yield self._record(opcode, data[begin:start], place)

    def _blocks(self, file: BinaryIO) -> Iterator[Block]:
        while self._size is None or self._place < self._size:
            head, content = self._next(file)
            if content is None:
                return
            opcode = head[0]
            if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                self._end(opcode, head, content)
            if opcode == Opcode.FOOTER:
                self._finish(file)
                return
            if opcode != Opcode.DATA_END:
                self._checksum = zlib.crc32(content, zlib.crc32(head, self._checksum))
            # The index repeats what was read before.
            if not self._data_ended and (opcode in _TYPES or opcode == Opcode.MESSAGE):
                yield Block(self, self._place, self._record(opcode, content, self._place))
            self._place += len(head) + len(content)
        if self._place != self._size:
            raise Damaged(self.path, self._place, f"a record extends beyond byte {self._size:,}")

    def _next(self, file: BinaryIO) -> tuple[bytes, bytes | None]:
        """Head and content of the next record; content is None where the file was cut."""
        head, read = file.read(_HEAD.size), 0
        if len(head) == _HEAD.size:
            length = _HEAD.unpack(head)[1]
            if length > LIMIT:
                raise Damaged(self.path, self._place, f"a record of {length:,} bytes, more than {LIMIT:,}")
            content = file.read(length)
            if len(content) == length:
                return head, content
            read = len(content)
        if self._size is not None:
            raise Damaged(self.path, self._place + len(head) + read, f"it ends there, {self._size:,} were written")
        return head, None

    def _end(self, opcode: int, head: bytes, content: bytes) -> None:
        """Verify the checksum of all records since the previous checksum, and begin a new one."""
        end = len(content) - 4
        if opcode == Opcode.FOOTER:
            self._checksum = zlib.crc32(content[:end], zlib.crc32(head, self._checksum))
        if self._data_ended != (opcode == Opcode.FOOTER) or content[end:] != self._checksum.to_bytes(4, "little"):
            what = "its index" if opcode == Opcode.FOOTER else "the data before it"
            raise Damaged(self.path, self._place, f"the checksum of {what} differs")
        self._checksum, self._data_ended = 0, True

    def _finish(self, file: BinaryIO) -> None:
        """Verify the bytes after the last record."""
        rest = file.read(len(MCAP0_MAGIC) + 1)
        if not MCAP0_MAGIC.startswith(rest):
            raise Damaged(self.path, self._place, "its end is followed by something else")
        self.has_end = rest == MCAP0_MAGIC

    def _record(self, opcode: int, content: bytes, place: int) -> McapRecord:
        try:
            if opcode == Opcode.MESSAGE:
                channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(content)
                if channel not in self._channels:
                    raise Damaged(self.path, place, f"a message of the unknown channel {channel}")
                return Message(channel, log_time, content[_MESSAGE.size :], publish_time, sequence)
            if opcode != Opcode.CHUNK and len(content) > SMALL:
                raise Damaged(self.path, place, f"a record of {len(content):,} bytes, more than {SMALL:,}")
            record: McapRecord = _TYPES[opcode].read(ReadDataStream(BytesIO(content)))
            if isinstance(record, Chunk):
                return self._unpack(record, place)
        except _BROKEN as error:
            raise Damaged(self.path, place, f"it cannot be read: {type(error).__name__}") from None
        if isinstance(record, Channel):
            self._channels.add(record.id)
        return record

    def _unpack(self, chunk: Chunk, place: int) -> Chunk:
        size = chunk.uncompressed_size
        self._unpacked += size
        if size > LIMIT:
            raise Damaged(self.path, place, f"a chunk of {size:,} bytes, more than {LIMIT:,}")
        if self._unpacked > FREE + RATIO * place:
            raise Damaged(self.path, place, f"it unpacks to more than {FREE:,} bytes and {RATIO} times its size")
        data = chunk.data
        if chunk.compression == "zstd":
            # If the compressed data state a length, the library uses it.
            if zstandard.frame_content_size(data) not in (-1, size):
                raise Damaged(self.path, place, "a chunk does not have the length that it states")
            data = zstandard.ZstdDecompressor(max_window_size=LIMIT).decompress(data, max_output_size=size)
        elif chunk.compression:
            raise Damaged(self.path, place, f"a chunk compressed as {chunk.compression[:20]!r}, not as 'zstd'")
        if len(data) != size or zlib.crc32(data) != chunk.uncompressed_crc:
            raise Damaged(self.path, place, "the checksum of a chunk differs")
        return replace(chunk, data=data, compression="")
