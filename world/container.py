"""The file of a log: topics, schemas and chunks, through the mcap library."""

import contextlib
import json
import time
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from fes.errors import FesError
from world.descriptors import describe
from world.protobuf import Message

PROFILE = "fes"

CHUNK = 1 << 19
"""A chunk is closed when it holds this much [bytes, not compressed]; then about 100 ticks of ten robots."""

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
            self._writer.start(PROFILE, f"fes {version('fes')}; mcap-python {version('mcap')}")

    def put(self, topic: str, schema: Schema, payload: bytes, at: int, tick: int) -> None:
        """Add a message of a topic, `at` a simulated time [ns]; nothing to a file that could not be written."""
        if self._broken:
            return
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._register(topic, schema)
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
            name, encoding, kind = schema.name, "protobuf", "protobuf"
        else:
            name, encoding, kind = schema["title"], "json", "jsonschema"
        if name not in self._schemas:
            described = describe(schema) if isinstance(schema, Message) else json.dumps(schema).encode()
            self._schemas[name] = self._writer.register_schema(name, kind, described)
        return self._writer.register_channel(topic, encoding, self._schemas[name])

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._broken = True
            raise FesError(f"cannot write {self._path}: {error.strerror}") from None
