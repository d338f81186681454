"""Logs of runs, read back; docs/log.md says what is in them."""

import json
import struct
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC

from fes.errors import FesError
from fes.report import Report, decode_report
from world import protobuf, schemas
from world.recorder import NAME, SUMMARY, Said
from world.scenario import Scenario, parse

_EVIDENCE = ("/observations", "/beacons", "/commands")
_BROKEN = (McapError, CRCValidationError, zstandard.ZstdError, struct.error, UnicodeDecodeError, MemoryError)


class Tick(NamedTuple):
    """All that was said at one tick."""

    number: int
    said: Said
    changes: list[tuple[str, Any]]
    """What persons set of the channel: path and value."""
    present: list[int] | None
    """The robots that are there from this tick on, where that changed otherwise than by schedule."""
    report: Report | None
    """At one of several ticks."""


@dataclass(frozen=True)
class Log:
    """A log; its ticks are read anew from the file each time."""

    path: Path
    name: str
    """Of the scenario."""
    backend: str
    scenario: Scenario
    summary: dict[str, Any] | None
    """Of what was reached; None if the log has no end."""
    ended: str | None
    """How the run ended; None if the log has no end."""

    def ticks(self) -> Iterator[Tick]:
        """Its ticks, in order; of a log without an end those that are whole. Raises FesError."""
        try:
            for expected, tick in enumerate(_ticks(self.path)):
                if tick.number != expected:
                    raise FesError(f"{self.path}: after tick {expected - 1} comes tick {tick.number}")
                yield tick
        except (ValueError, KeyError, IndexError, TypeError) as error:
            raise FesError(f"{self.path}: a message is not what its topic promises: {error}") from None

    @property
    def complaint(self) -> str | None:
        """What is to be said of a log without an end."""
        if self.ended is not None:
            return None
        whole = sum(1 for _ in self.ticks())
        of = f"{whole} of {self.scenario.ticks} ticks are there"
        return f"{self.path} has no end, its run was killed or the file was cut: {of}"


def find(target: Path) -> Path | None:
    """The log that is meant by a file or by a run directory; None for a run directory without one."""
    if not target.is_dir():
        return target
    return target / NAME if (target / NAME).is_file() else None


def load(target: Path) -> Log:
    """A log with a tick at least: a file, or that of a run directory; raises FesError in one line."""
    path = find(target)
    if path is None:
        raise FesError(f"{target} has no {NAME}: the run was not recorded")
    told = _scenario(path)
    if told.get("log") != schemas.VERSION:
        raise FesError(f"{path} is a log of version {told.get('log')}; this fes reads version {schemas.VERSION}")
    ended = _metadata(path)
    try:
        scenario = parse(tomllib.loads(told["scenario"]), str(path))
        summary = json.loads(ended["summary"]) if ended and "summary" in ended else None
        log = Log(path, told["name"], told["backend"], scenario, summary, ended["ended"] if ended else None)
    except (KeyError, TypeError, ValueError) as error:
        raise FesError(f"{path}: what it says of its run cannot be read: {error}") from None
    if next(log.ticks(), None) is None:
        raise FesError(log.complaint or f"{path}: the run was over before its first tick")
    return log


def _scenario(path: Path) -> dict[str, Any]:
    """What the log says of its run: its first message."""
    with suppress(ValueError):
        for topic, message in _messages(path):
            if topic == "/scenario":
                told = json.loads(message.data)
                if isinstance(told, dict):
                    return told
            break
    raise FesError(f"{path} is not a log of a run: it does not begin with its scenario")


def _metadata(path: Path) -> dict[str, str] | None:
    """What was written when the log was closed; None if it was not."""
    try:
        with path.open("rb") as file:
            return next((one.metadata for one in make_reader(file).iter_metadata() if one.name == SUMMARY), None)
    except (*_BROKEN, OSError, ValueError):
        return None


def _ticks(path: Path) -> Iterator[Tick]:
    number, said, changes, report = -1, dict[str, list[bytes]](), list[tuple[str, Any]](), None
    present: list[int] | None = None
    for topic, message in _messages(path):
        if topic == _EVIDENCE[0] and said:
            yield Tick(number, Said(*(said[name] for name in _EVIDENCE)), changes, present, report)
            said, changes, present, report = {}, [], None, None
        if topic in _EVIDENCE:
            fields = list(protobuf.fields(message.data))
            number = next(int(value) for field, value in fields if field == 1)
            said[topic] = [bytes(value) for field, value in fields if field == 2]
        elif topic == "/events":
            event = json.loads(message.data)
            if event["what"] == "set" and event["by"] == "person" and event["tick"] == number:
                changes.append((event["path"], event["value"]))
            elif event["what"] == "present" and event["tick"] == number:
                present = event["robots"]
        elif topic == "/report":
            report = decode_report(next(bytes(value) for field, value in protobuf.fields(message.data) if field == 2))
    if said:
        yield Tick(number, Said(*(said[name] for name in _EVIDENCE)), changes, present, report)


def _messages(path: Path) -> Iterator[tuple[str, Message]]:
    """Topic and message, in the order of the file; of a file that was cut, up to its last whole chunk."""
    topics: dict[int, str] = {}
    for record in _records(path):
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            yield topics[record.channel_id], record


def _records(path: Path) -> Iterator[McapRecord]:
    try:
        with path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise FesError(f"{path} is not a log: it is not an MCAP file")
            file.seek(0)
            for record in StreamReader(file, emit_chunks=True, validate_crcs=True).records:
                if isinstance(record, DataEnd):
                    return
                if not isinstance(record, Chunk):
                    yield record
                    continue
                try:
                    inside = breakup_chunk(record, validate_crc=True)
                except _BROKEN as error:
                    raise FesError(f"{path} is damaged: {error}") from None
                yield from inside
    except (EndOfFile, struct.error):
        return  # it was cut here: only whole records have been read
    except _BROKEN as error:
        raise FesError(f"{path} is damaged: {error}") from None
    except OSError as error:
        raise FesError(f"{path}: {error.strerror}") from None
