"""Small files crafted to exhaust time or memory: logs, checkpoints, sweeps and announcements of a run."""

import hashlib
import json
import pickle
import struct
import zlib
from collections.abc import Callable, Iterable
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import tomli_w
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.writer import MCAP0_MAGIC

from fes.recording import records, schemas
from fes.recording.messages_pb2 import Observations
from fes.system import fingerprint
from tests.support.loop import load
from world.execution import snapshot

MIB = 1 << 20
MUCH = 1 << 30
"""Size to which no file may unpack [bytes]."""

SCENARIO, OBSERVATIONS, EVENTS, FOREIGN = 1, 2, 3, 4
TOPICS = {SCENARIO: "/scenario", OBSERVATIONS: "/observations", EVENTS: "/events", FOREIGN: "/foreign"}


def framed(opcode: int, content: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def written(*content: McapRecord) -> bytes:
    builder = RecordBuilder()
    for record in content:
        record.write(builder)
    return bytes(builder.end())


def chunk(data: bytes, size: int | None = None, packed: bytes | None = None, how: str = "zstd") -> bytes:
    """A chunk that holds, or claims to hold, records."""
    packed = zstandard.compress(data) if packed is None else packed
    return written(Chunk(how, packed, 0, 0, zlib.crc32(data), len(data) if size is None else size))


@cache
def zeros(size: int, stated: bool) -> bytes:
    """Compressed zeros; the frame may state their number."""
    out = BytesIO()
    with zstandard.ZstdCompressor().stream_writer(out, size=size if stated else -1, closefd=False) as into:
        for _ in range(size // MIB):
            into.write(bytes(MIB))
    return out.getvalue()


def message(channel: int, data: bytes, tick: int = 0) -> bytes:
    return written(Message(channel, 0, data, 0, tick))


def topics(ids: Iterable[int] = TOPICS) -> bytes:
    return written(Schema(1, b"{}", "jsonschema", "any"), *(Channel(id_, TOPICS[id_], "json", {}, 1) for id_ in ids))


def header(scenario: str | None = None, **changes: Any) -> bytes:
    """The first message of a log of two robots."""
    tables = load("pair.toml", run__duration=1.0).model_dump(mode="json", by_alias=True, exclude_none=True)
    fields = {
        "log": schemas.VERSION,
        "name": "x",
        "backend": "processes",
        "scenario": scenario or tomli_w.dumps(tables),
    }
    return message(
        SCENARIO, json.dumps({**fields, "arithmetic": fingerprint.table(), "versions": {}, **changes}).encode()
    )


def torn(*parts: bytes) -> bytes:
    """A log that ends after these records."""
    return MCAP0_MAGIC + framed(1, bytes(8)) + b"".join(parts)


def begun(*messages: bytes, scenario: bytes | None = None) -> bytes:
    """A log with its scenario and further messages in one chunk."""
    return torn(chunk(topics() + (header() if scenario is None else scenario) + b"".join(messages)))


def observations(tick: int, payloads: int) -> bytes:
    empty = b"\x12\x00"
    return bytes(Observations(tick=tick).SerializeToString()) + empty * payloads


def attended(robots: bytes) -> bytes:
    return message(EVENTS, b'{"tick": 0, "what": "present", "robots": ' + robots + b"}")


def ticks(count: int) -> bytes:
    """Ticks of two robots that are absent."""
    team = written(
        *(
            Channel(10 + index, name, "protobuf", {}, 1)
            for index, name in enumerate(("/observations", "/beacons", "/commands"))
        )
    )
    return team + b"".join(
        message(10 + index, observations(tick, 2), tick) for tick in range(count) for index in range(3)
    )


@cache
def entries() -> bytes:
    """Largest number of table entries in one record."""
    return b"".join(b"\x07\0\0\0%07d\0\0\0\0" % number for number in range(records.SMALL // 15 - 10))


def repeated(record: bytes, size: int) -> bytes:
    return record * (size // len(record))


def nested(text: str, depth: int = 100_000) -> str:
    return text * depth


LOGS: dict[str, Callable[[], bytes]] = {
    "a chunk that unpacks to a gigabyte": lambda: torn(chunk(b"", MUCH, zeros(MUCH, stated=True))),
    "a chunk whose frame tells of a gigabyte": lambda: torn(chunk(b"", 1000, zeros(MUCH, stated=True))),
    "a chunk whose frame does not tell": lambda: torn(chunk(b"", 1000, zeros(MUCH, stated=False))),
    "a chunk of lz4": lambda: torn(chunk(b"", 1000, b"x", "lz4")),
    "a chunk of another length": lambda: torn(chunk(b"x" * 1000, 999)),
    "a chunk that says nothing of its length": lambda: torn(chunk(b"", 0, zeros(MUCH, stated=False))),
    "many chunks": lambda: torn(chunk(topics() + header()), chunk(repeated(message(FOREIGN, b""), 60 * MIB)) * 20),
    "a record of any length": lambda: torn(struct.pack("<BQ", 6, 1 << 63)),
    "a record longer than the file": lambda: torn(struct.pack("<BQ", 6, 60 * MIB)),
    "a text of any length": lambda: torn(framed(6, struct.pack("<QQQII", 0, 0, 1, 1, 0xFFFFFFFF))),
    "data of any length": lambda: torn(framed(6, struct.pack("<QQQIIQ", 0, 0, 1, 1, 0, 1 << 63))),
    "a message that is too short": lambda: torn(framed(5, b"abc")),
    "a message of no channel": lambda: torn(message(7, b"")),
    "unknown records": lambda: torn(repeated(framed(0x7F, b""), 2 * MIB)),
    "unknown records in a chunk": lambda: torn(chunk(repeated(framed(0x7F, b""), 60 * MIB))),
    "a chunk in a chunk": lambda: torn(chunk(chunk(b""))),
    "channels without end": lambda: torn(
        chunk(written(Schema(1, b"", "", "any"), *(Channel(at, f"/{at:0900d}", "", {}, 1) for at in range(60_000))))
    ),
    "a channel with a large table": lambda: torn(
        chunk(framed(4, struct.pack("<HHIII", 1, 0, 0, 0, len(entries())) + entries()))
    ),
    "a large table at the end": lambda: torn(framed(12, struct.pack("<II", 0, len(entries())) + entries())),
    "a table that is too large": lambda: torn(framed(12, bytes(records.SMALL + 1))),
    "a wide scenario": lambda: begun(scenario=message(SCENARIO, b"[" + b"[]," * (6 * MIB) + b"0]")),
    "a deep scenario": lambda: begun(scenario=message(SCENARIO, nested("[").encode())),
    "a deep table": lambda: begun(scenario=header("x=" + nested("["))),
    "a number of many digits": lambda: begun(scenario=header("dt=" + nested("1", 5_000))),
    "a number of robots": lambda: begun(scenario=header("schema = 1\n[robots]\ncount = 1000000000\n")),
    "an arithmetic that is a list": lambda: begun(scenario=header(arithmetic=[])),
    "an arithmetic with colors": lambda: begun(
        scenario=header(arithmetic={**fingerprint.table(), "numpy": "\033[31m"})
    ),
    "payloads without end": lambda: begun(message(OBSERVATIONS, observations(0, 30 * MIB))),
    "events without end": lambda: begun(ticks(1), repeated(message(EVENTS, b'{"tick": 0, "what": "x"}'), 60 * MIB)),
    "robots beyond all numbers": lambda: begun(ticks(1), attended(b"[1e999]")),
    "robots that are not": lambda: begun(ticks(1), attended(b"[0, 7]")),
    "a version that is a text": lambda: begun(scenario=header(log="x" * MIB)),
    "a name that is a list": lambda: begun(scenario=header(name=[1])),
    "a deep event": lambda: begun(ticks(1), message(EVENTS, nested("[").encode())),
    "ticks without end": lambda: begun(ticks(10_000)),
}
"""Small files, none of which this program wrote."""


def state(pickled: bytes, **head: Any) -> bytes:
    """A checkpoint with a correct checksum."""
    content = json.dumps({"arithmetic": fingerprint.table(), **head}).encode() + b"\n" + pickled
    return b"fes checkpoint %d\n%s\n%s" % (snapshot.FORMAT, hashlib.sha256(content).hexdigest().encode(), content)


STATES: dict[str, Callable[[], bytes]] = {
    "a place beyond all memory": lambda: state(b"\x80\x05Nr\xff\xff\xff\x7f."),
    "bytes beyond all memory": lambda: state(b"\x80\x05\x96" + struct.pack("<Q", 1 << 40) + b"."),
    "a nest": lambda: state(b"\x80\x05" + b"(" * MIB + b"."),
    "a table without its fields": lambda: state(pickle.dumps(object.__new__(snapshot.Snapshot))),
    "an arithmetic that is a list": lambda: state(b"N.", arithmetic=[]),
}

LINES: dict[str, Callable[[], bytes]] = {
    "a line without end": lambda: bytes(20 * MIB),
    "a deep line": lambda: nested("[").encode() + b"\n",
    "a list": lambda: b"[]\n",
    "a key that is a list": lambda: b'{"key": [], "scalars": {}, "error": null, "crc32": "00000000"}\n',
}

TABLES: dict[str, Callable[[], bytes]] = {
    "a large table": lambda: b"[" + b"0," * (35 * MIB) + b"0]",
    "a deep table": lambda: nested('{"endpoint":').encode(),
    "a list": lambda: b"[]",
    "other fields": lambda: b'{"x": 1}',
    "numbers": lambda: b'{"endpoint": 1, "run": "main", "pid": 1, "keys": null}',
    "a long number": lambda: (
        b'{"endpoint": "tcp/127.0.0.1:1", "run": "main", "pid": ' + b"9" * 4000 + b', "keys": null}'
    ),
    "no text": lambda: b"\xff\xfe\x00",
}


FILES = {"logs": LOGS, "states": STATES, "lines": LINES, "tables": TABLES}


def write(where: Path) -> None:
    """Write all files, each kind in its own subfolder."""
    for kind, made in FILES.items():
        (where / kind).mkdir()
        for name, make in made.items():
            (where / kind / name).write_bytes(make())
