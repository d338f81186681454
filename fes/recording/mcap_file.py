"""The file of a log: topics, schemas and chunks, through the mcap library."""

import contextlib
import hashlib
import time
from collections import deque
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import IO, Any, cast

from google.protobuf.message import Message
from mcap.records import Channel as McapChannel
from mcap.records import Message as McapMessage
from mcap.records import Schema as McapSchema
from mcap.writer import CompressionType, Writer

from fes.errors import FesError, reason
from fes.protocol import world_info
from fes.recording import hashed_file, records
from fes.recording.hashed_file import HashedFile
from fes.recording.protobuf import describe
from fes.recording.records import Block, Damaged, Reader
from fes.system import strict_json

PROFILE = "fes"

CHUNK = 1 << 21
"""A chunk is closed when it holds this much [bytes, uncompressed], about 400 ticks of ten robots. The index of all
chunks stays in memory until the end, about 2 kB per chunk."""

CHUNK_AGE = 1.5
"""A chunk is closed when it is this old [s; wall clock]. A run that is killed together with the writer of its log
loses this much, and the time until its last ticks reach the writer: less than two seconds."""

LARGEST = records.LIMIT - (records.LIMIT >> 6)
"""A chunk holds at most this much [bytes, uncompressed]. So a reader accepts it even if it does not compress."""

_MESSAGE_HEADER = 31  # bytes

Schema = type[Message] | dict[str, Any]
"""Schema of a topic: a message type of Protocol Buffers, or a JSON schema."""


class McapFile:
    """A file of messages, in the order in which they are put; raises FesError if it cannot be written."""

    def __init__(self, path: Path, fileno: int | None = None) -> None:
        """`fileno` is the number of the file if it is open already."""
        self._path = path
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._waiting = self._unpacked = 0
        self._begun = time.monotonic()
        self._broken = False
        self.loss: str | None = None
        """Damage by other programs to the finished file, in words; None without any, or before the end."""
        with self._writing():
            self._file = HashedFile(path, fileno)
            # Chunks are closed by `settle`, between two ticks, and not by the library in the middle of one.
            self._writer = Writer(
                cast(IO[bytes], self._file),
                chunk_size=1 << 40,
                compression=CompressionType.ZSTD,
                enable_data_crcs=True,
            )
            self._writer.start(PROFILE, f"fes {world_info.version()}; mcap-python {metadata.version('mcap')}")

    def put(self, topic: str, schema: Schema, payload: bytes, time_ns: int, tick: int) -> None:
        """Add a message of a topic at a simulated time; does nothing if the file could not be written."""
        if self._broken:
            return
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._register(topic, schema)
        self._writer.add_message(channel, time_ns, payload, time_ns, tick)
        self._waiting += len(payload) + _MESSAGE_HEADER

    def settle(self, at_once: bool = False) -> None:
        """Close the chunk if it is large or old enough, or `at_once`: from then on a reader finds its messages."""
        if self._broken:
            return  # the error was raised before
        is_old = self._waiting > 0 and time.monotonic() - self._begun >= CHUNK_AGE
        if at_once or is_old or self._waiting >= CHUNK:
            self._check_size()
            with self._writing():
                self._writer.flush()
            self._waiting, self._begun = 0, time.monotonic()

    def _check_size(self) -> None:
        """Raise FesError if a reader would reject the file with the chunk that is about to be closed."""
        self._unpacked += self._waiting
        why = None
        if self._waiting > LARGEST:
            why = f"a tick takes {self._waiting:,} bytes, of at most {LARGEST:,}"
        elif self._unpacked > (records.FREE + records.RATIO * self._file.size) // 2:  # channels are not counted
            why = f"it is so uniform that {self._unpacked:,} bytes take {self._file.size:,}"
        if why is not None:
            self._broken = True
            raise FesError(f"cannot write {self._path}: {why}: --no-record runs without a log")

    def close_chunk(self) -> int:
        """Close the chunk; returns the size of the file [bytes], which then consists of whole records."""
        self.settle(at_once=True)
        return self._file.size

    @property
    def fileno(self) -> int:
        """The number of the open file."""
        return self._file.fileno()

    @property
    def sha256(self) -> str:
        """SHA-256 of all bytes so far, in hexadecimal."""
        return self._file.sha256

    def copy(self, path: Path, size: int) -> None:
        """Copy all messages in the first `size` bytes of another log, chunk by chunk, and verify the copy.

        Raises FesError, also if the other log is damaged.
        """
        copied, written = _Contents(), _Contents()
        try:
            for block in Reader(path, size):
                for message, channel, schema in copied.messages(block):
                    self._add_copy(message, channel, schema)
                self.settle(at_once=True)
            for block in Reader(self._path, self.close_chunk()):
                deque(written.messages(block), maxlen=0)
            if written.sha256 != copied.sha256:
                raise FesError(f"{self._path} does not hold what was copied to it")
        except FesError:
            self._file.close()
            raise

    def finish(self, name: str, metadata: dict[str, str]) -> None:
        """Close the file, with a record of metadata and an index."""
        self.settle(at_once=True)
        if self._broken:
            self.close()
            return
        with self._writing(), contextlib.closing(self._file):
            self._writer.add_metadata(name, metadata)
            self._writer.finish()
            self._file.flush()
            self.loss = hashed_file.loss(self._path, self.fileno, self._file.size)

    def close(self) -> None:
        """Close the file as it is: without its end, and without messages that are in no chunk yet."""
        with contextlib.suppress(OSError):
            self._file.close()

    def _register(self, topic: str, schema: Schema) -> int:
        if isinstance(schema, dict):
            return self._declare(topic, "json", schema["title"], "jsonschema", strict_json.dumps(schema).encode())
        return self._declare(topic, "protobuf", schema.DESCRIPTOR.full_name, "protobuf", describe(schema))

    def _declare(self, topic: str, encoding: str, name: str, kind: str, described: bytes) -> int:
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(name, kind, described)
        channel = self._channels[topic] = self._writer.register_channel(topic, encoding, self._schemas[name])
        return channel

    def _add_copy(self, message: McapMessage, source: McapChannel, schema: McapSchema) -> None:
        channel = self._channels.get(source.topic)
        if channel is None:
            channel = self._declare(source.topic, source.message_encoding, schema.name, schema.encoding, schema.data)
        self._writer.add_message(channel, message.log_time, message.data, message.publish_time, message.sequence)

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._broken = True
            raise FesError(f"cannot write {self._path}: {reason(error, with_file=False)}") from None


class _Contents:
    """The messages of a log, as far as it was read, each with its topic and schema."""

    def __init__(self) -> None:
        self._channels = dict[int, McapChannel]()
        self._schemas = dict[int, McapSchema]()
        self._topics = set[str]()
        self._hash = hashlib.sha256()

    def messages(self, block: Block) -> Iterator[tuple[McapMessage, McapChannel, McapSchema]]:
        """The messages of the next block."""
        for record in block:
            if isinstance(record, McapSchema):
                self._schemas[record.id] = record
            elif isinstance(record, McapChannel):
                self._channels[record.id] = record
            elif isinstance(record, McapMessage):
                channel = self._channels[record.channel_id]
                schema = self._schemas.get(channel.schema_id)
                if schema is None:
                    raise Damaged(block.reader.path, block.place, f"{channel.topic[:60]!r} has no schema")
                if channel.topic not in self._topics:
                    self._topics.add(channel.topic)
                    self._hash.update(schema.data)
                identity = (channel.topic, schema.name, record.sequence, record.log_time, len(record.data))
                self._hash.update(repr(identity).encode() + record.data)
                yield record, channel, schema

    @property
    def sha256(self) -> str:
        """SHA-256 of all messages so far."""
        return self._hash.hexdigest()
