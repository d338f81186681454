"""Logs of runs, read back; docs/log.md says what is in them."""

import itertools
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, Message, Metadata

from fes import fingerprint, strict_json
from fes.errors import FesError, MessageError
from fes.report import Report, decode_report
from world import protobuf, schemas
from world.recorder import AT_ITS_END, MAX_JSON, NAME, SUMMARY, Said
from world.records import Reader
from world.scenario import Scenario, parse

_EVIDENCE = ("/observations", "/beacons", "/commands")
_TOPICS = (*_EVIDENCE, "/scenario", "/report", "/events")
"""All topics that are read back."""

_MAX_EVENTS = 10_000  # per tick

_UNREADABLE = (ValueError, KeyError, IndexError, TypeError, AttributeError, RecursionError, OverflowError)


class Tick(NamedTuple):
    """All that was said at one tick."""

    number: int
    said: Said
    changes: list[tuple[str, Any]]
    """What persons set of the channel: path and value."""
    scheduled: list[tuple[str, Any]]
    """What was set by the schedule."""
    attended: list[list[int]]
    """The robots that are there from this tick on, each time that changed otherwise than by schedule, in order."""
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
    arithmetic: Mapping[str, str] = field(default_factory=fingerprint.table)
    """The arithmetic with which it was recorded."""

    def ticks(self) -> Iterator[Tick]:
        """Its ticks, in order; of a log without an end those that are whole. Raises FesError."""
        there = 0
        try:
            for expected, tick in enumerate(_ticks(self.path, self.scenario.robots.number)):
                if tick.number != expected:
                    raise FesError(f"{self.path}: after tick {expected - 1} comes tick {tick.number}")
                if expected >= self.scenario.ticks:
                    raise FesError(f"{self.path}: it continues after tick {expected - 1}, the last of its scenario")
                yield tick
                there = expected + 1
        except _UNREADABLE as error:
            raise FesError(f"{self.path}: a message is not what its topic promises: {_line(error)}") from None
        if self.summary is not None and there != self.summary.get("ticks"):
            raise FesError(f"{self.path}: {there} ticks are there, and its summary is of {self.summary.get('ticks')}")
        if self.ended == AT_ITS_END and there != self.scenario.ticks:
            raise FesError(f"{self.path}: {there} of {self.scenario.ticks} ticks are there, and no reason why")

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
        version = f"{told.get('log')!r:.20}"
        raise FesError(f"{path} is a log of version {version}; this fes reads version {schemas.VERSION}")
    ended = _metadata(path)
    try:
        summary = strict_json.loads(ended["summary"]) if ended and "summary" in ended else None
        if summary is not None and not isinstance(summary, dict):
            raise TypeError("its summary is not a table")
        scenario = parse(tomllib.loads(told["scenario"]), str(path))
        fingerprint.text(told["arithmetic"])  # raises one of these errors where it names none
        if not all(isinstance(told[key], str) for key in ("name", "backend")):
            raise TypeError("its name and backend are texts")
        how = ended["ended"] if ended else None
        log = Log(path, told["name"], told["backend"], scenario, summary, how, told["arithmetic"])
    except _UNREADABLE as error:
        raise FesError(f"{path}: what it says of its run cannot be read: {_line(error)}") from None
    if next(log.ticks(), None) is None:
        raise FesError(log.complaint or f"{path}: the run was over before its first tick")
    return log


def _scenario(path: Path) -> dict[str, Any]:
    """What the log says of its run: its first message."""
    with suppress(ValueError, RecursionError):
        for topic, message in _messages(path):
            if topic == "/scenario":
                told = _parsed(message.data)
                if isinstance(told, dict):
                    return told
            break
    raise FesError(f"{path} is not a log of a run: it does not begin with its scenario")


def _metadata(path: Path) -> dict[str, str] | None:
    """The metadata written when the log was closed; None if it was not. Raises FesError unless the log is whole."""
    reader, found = Reader(path), None
    for block in reader:
        if isinstance(block.record, Metadata) and block.record.name == SUMMARY:
            found = block.record.metadata
    return found if reader.has_end else None


def _ticks(path: Path, robots: int) -> Iterator[Tick]:
    """The ticks of a file; raises FesError, or one of what is unreadable."""
    for number, found in itertools.groupby(_numbered(path), key=itemgetter(0)):
        said, set_ = dict[str, list[bytes]](), {"person": list[tuple[str, Any]](), "schedule": []}
        attended: list[list[int]] = []
        report: Report | None = None
        events = 0
        for _, topic, data in found:
            if topic in _EVIDENCE:
                said[topic] = _payloads(path, topic, data, number, robots)
            elif topic == "/report":
                try:
                    report = decode_report(next(iter(_contents(data)), b""))
                except MessageError as error:
                    raise FesError(f"{path}: tick {number}: {error}") from None
            elif (event := _parsed(data))["tick"] == number:
                if (events := events + 1) > _MAX_EVENTS:
                    raise FesError(f"{path}: tick {number} has more than {_MAX_EVENTS:,} events")
                if event["what"] == "set":
                    set_[event["by"]].append((str(event["path"]), event["value"]))
                elif event["what"] == "present":
                    attended.append([int(robot) for robot in event["robots"]])
                    if not all(0 <= robot < robots for robot in attended[-1]):
                        raise FesError(f"{path}: tick {number}: a robot takes part that is not one of {robots}")
        for topic in _EVIDENCE:
            if topic not in said:
                raise FesError(f"{path}: tick {number} has no message on {topic}")
        all_ = Said(*(said[topic] for topic in _EVIDENCE))
        yield Tick(number, all_, set_["person"], set_["schedule"], attended, report)


def _numbered(path: Path) -> Iterator[tuple[int, str, bytes]]:
    """Tick, topic and content of each message that is read back; a tick begins with its Observations."""
    number = -1
    for topic, message in _messages(path):
        if topic == _EVIDENCE[0]:
            after = _tick(message.data)
            if after < 0:
                raise FesError(f"{path}: a message on {topic} has no tick")
            if after == number:
                raise FesError(f"{path}: tick {number} has two messages on {topic}")
            number = after
        if topic != "/scenario" and number >= 0:
            yield number, topic, message.data


def _tick(data: bytes) -> int:
    """The tick in a message of all robots; -1 if there is none."""
    return next((int(value) for field, value in protobuf.fields(data) if field == 1), -1)


def _contents(data: bytes, limit: int = 1) -> list[bytes]:
    """The payloads in a message, at most one more than `limit`."""
    found = (value for field, value in protobuf.fields(data) if field == 2 and isinstance(value, bytes))
    return list(itertools.islice(found, limit + 1))


def _parsed(data: bytes) -> Any:
    """The value of a message in JSON; raises ValueError."""
    if len(data) > MAX_JSON:
        raise ValueError(f"a text of {len(data):,} bytes, more than {MAX_JSON:,}")
    return strict_json.loads(data)


def _payloads(path: Path, topic: str, data: bytes, number: int, robots: int) -> list[bytes]:
    """The payloads of a message of all robots, which must be of this tick and one a robot."""
    if _tick(data) != number:
        raise FesError(f"{path}: tick {number}: the message on {topic} is of tick {_tick(data)}")
    found = _contents(data, robots)
    if len(found) != robots:
        raise FesError(f"{path}: tick {number}: {topic} has {len(found)} payloads, there are {robots} robots")
    return found


def _line(error: Exception) -> str:
    """An error of whatever cannot be read, in a line."""
    if isinstance(error, RecursionError):
        return "it is nested too deeply"
    return " ".join(f"{type(error).__name__}: {error}".split()) if isinstance(error, KeyError) else str(error)


def _messages(path: Path) -> Iterator[tuple[str, Message]]:
    """Topic and message, in the order of the file; of a file that was cut, up to its last whole chunk."""
    topics: dict[int, str] = {}
    for block in Reader(path):
        for record in block:
            if isinstance(record, Channel):
                topics[record.id] = record.topic if record.topic in _TOPICS else ""
            elif isinstance(record, Message) and topics[record.channel_id]:
                yield topics[record.channel_id], record
