"""The file of a log: topics, schemas and chunks, through the mcap library."""

import contextlib
import struct
import time
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel as McapChannel
from mcap.records import Chunk
from mcap.records import Message as McapMessage
from mcap.records import Schema as McapSchema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import CompressionType, Writer

from fes import distribution, strict_json
from fes.errors import FesError, reason
from world.descriptors import describe
from world.protobuf import Message

PROFILE = "fes"

CHUNK = 1 << 21
"""A chunk is closed when it holds this much [bytes, not compressed]; then about 400 ticks of ten robots. The index of
all chunks stays in memory until the end, about 2 kB each."""

CHUNK_AGE = 2.0
"""A chunk is closed when it is this old [s; wall clock], which is how much a run that is killed may lose."""

_MESSAGE_HEADER = 31  # bytes

Schema = Message | dict[str, Any]
"""Of a topic: a type of Protocol Buffers, or a JSON schema."""


class Container:
    """A file of messages, in the order in which they are put; raises FesError where it cannot be written."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._waiting = 0
        self._begun = time.monotonic()
        self._broken = False
        with self._writing():
            self._file = path.open("wb")
            # Chunks are closed by `settle`, between two ticks, and not by the library in the middle of one.
            self._writer = Writer(
                self._file, chunk_size=1 << 40, compression=CompressionType.ZSTD, enable_data_crcs=True
            )
            self._writer.start(PROFILE, f"fes {distribution.version()}; mcap-python {metadata.version('mcap')}")

    def put(self, topic: str, schema: Schema, payload: bytes, at: int, tick: int) -> None:
        """Add a message of a topic, `at` a simulated time [ns]; nothing to a file that could not be written."""
        if self._broken:
            return
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._register(topic, schema)
        self._writer.add_message(channel, at, payload, at, tick)
        self._waiting += len(payload) + _MESSAGE_HEADER

    def settle(self, at_once: bool = False) -> None:
        """Close the chunk if it is large or old enough, or `at_once`: a reader finds what it holds from then on."""
        if self._broken:
            return  # it was said once
        if at_once or self._waiting >= CHUNK or time.monotonic() - self._begun >= CHUNK_AGE:
            with self._writing():
                self._writer.flush()
            self._waiting, self._begun = 0, time.monotonic()

    def close_chunk(self) -> int:
        """Close the chunk; returns how many bytes there are then, all of them whole records."""
        self.settle(at_once=True)
        with self._writing():
            self._file.flush()
            return self._file.tell()
        return 0

    @property
    def fileno(self) -> int:
        """The number of the open file."""
        return self._file.fileno()

    def copy(self, path: Path, size: int) -> None:
        """Take over all messages in the first `size` bytes of another file, chunk by chunk."""
        try:
            self._copy(path, size)
        except (EndOfFile, McapError, UnicodeDecodeError, struct.error, zstandard.ZstdError) as error:
            self._file.close()
            raise FesError(f"it is damaged ({type(error).__name__})") from None

    def _copy(self, path: Path, size: int) -> None:
        schemas, channels = dict[int, McapSchema](), dict[int, McapChannel]()
        with path.open("rb") as file:
            for record in StreamReader(file, emit_chunks=True).records:
                for part in breakup_chunk(record) if isinstance(record, Chunk) else [record]:
                    if isinstance(part, McapSchema):
                        schemas[part.id] = part
                    elif isinstance(part, McapChannel):
                        channels[part.id] = part
                    elif isinstance(part, McapMessage):
                        channel = channels[part.channel_id]
                        self._again(part, channel, schemas[channel.schema_id])
                self.settle(at_once=True)
                if file.tell() >= size:
                    return
        raise EndOfFile

    def finish(self, name: str, metadata: dict[str, str]) -> None:
        """Close the file, with a record of metadata and an index."""
        self.settle(at_once=True)
        if self._broken:
            with contextlib.suppress(OSError):
                self._file.close()
            return
        with self._writing(), self._file:
            self._writer.add_metadata(name, metadata)
            self._writer.finish()

    def _register(self, topic: str, schema: Schema) -> int:
        if isinstance(schema, Message):
            return self._declare(topic, "protobuf", schema.name, "protobuf", describe(schema))
        return self._declare(topic, "json", schema["title"], "jsonschema", strict_json.dumps(schema).encode())

    def _declare(self, topic: str, encoding: str, name: str, kind: str, described: bytes) -> int:
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(name, kind, described)
        channel = self._channels[topic] = self._writer.register_channel(topic, encoding, self._schemas[name])
        return channel

    def _again(self, message: McapMessage, like: McapChannel, schema: McapSchema) -> None:
        channel = self._channels.get(like.topic)
        if channel is None:
            channel = self._declare(like.topic, like.message_encoding, schema.name, schema.encoding, schema.data)
        self._writer.add_message(channel, message.log_time, message.data, message.publish_time, message.sequence)

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._broken = True
            raise FesError(f"cannot write {self._path}: {reason(error, with_file=False)}") from None
