"""The ticks of a log, as its messages tell them."""

import itertools
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, Message

from fes.errors import FesError, MessageError
from fes.protocol.report import Report, decode_report
from fes.recording import protobuf
from fes.recording.layout import MAX_JSON, TickPayloads
from fes.recording.records import Reader
from fes.system import strict_json

_EVIDENCE = ("/observations", "/beacons", "/commands")
_TOPICS = (*_EVIDENCE, "/scenario", "/report", "/events")
"""All topics that are read back."""

_MAX_EVENTS = 10_000  # per tick

UNREADABLE = (ValueError, KeyError, IndexError, TypeError, AttributeError, RecursionError, OverflowError)


class LoggedTick(NamedTuple):
    """All that was said at one tick."""

    number: int
    said: TickPayloads
    changes: list[tuple[str, Any]]
    """What persons set of the channel: path and value."""
    scheduled: list[tuple[str, Any]]
    """What was set by the schedule."""
    attended: list[list[int]]
    """The robots that are there from this tick on, each time that changed otherwise than by schedule, in order."""
    report: Report | None
    """At one of several ticks."""


def read(path: Path, robots: int) -> Iterator[LoggedTick]:
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
            elif (event := parsed(data))["tick"] == number:
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
        all_ = TickPayloads(*(said[topic] for topic in _EVIDENCE))
        yield LoggedTick(number, all_, set_["person"], set_["schedule"], attended, report)


def _numbered(path: Path) -> Iterator[tuple[int, str, bytes]]:
    """Tick, topic and content of each message that is read back; a tick begins with its Observations."""
    number = -1
    for topic, message in messages(path):
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


def parsed(data: bytes) -> Any:
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


def one_line(error: Exception) -> str:
    """An error of whatever cannot be read, in a line."""
    if isinstance(error, RecursionError):
        return "it is nested too deeply"
    return " ".join(f"{type(error).__name__}: {error}".split()) if isinstance(error, KeyError) else str(error)


def messages(path: Path) -> Iterator[tuple[str, Message]]:
    """Topic and message, in the order of the file; of a file that was cut, up to its last whole chunk."""
    topics: dict[int, str] = {}
    for block in Reader(path):
        for record in block:
            if isinstance(record, Channel):
                topics[record.id] = record.topic if record.topic in _TOPICS else ""
            elif isinstance(record, Message) and topics[record.channel_id]:
                yield topics[record.channel_id], record
