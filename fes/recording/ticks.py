"""The ticks of a log, read from its messages."""

import itertools
from collections.abc import Collection, Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, Message

from fes.errors import FesError, MessageError
from fes.protocol import older
from fes.protocol.report import Report, decode_report
from fes.recording import messages_pb2, protobuf, schemas
from fes.recording.layout import MAX_JSON, TickPayloads
from fes.recording.messages_pb2 import Beacons, Commands, Observations
from fes.recording.records import Reader
from fes.system import strict_json

_TeamMessage = Observations | Beacons | Commands

_TEAM_TOPICS: dict[str, type[_TeamMessage]] = {
    "/observations": Observations,
    "/beacons": Beacons,
    "/commands": Commands,
}
"""Topics with one message of all robots per tick."""

TOPICS = (*_TEAM_TOPICS, "/scenario", "/report", "/events")
"""All topics of a run that are read."""

_MAX_EVENTS = 10_000  # per tick

UNREADABLE = (ValueError, KeyError, IndexError, TypeError, AttributeError, RecursionError, OverflowError)
"""Errors that a message raises if it is not what its topic promises."""


class LoggedTick(NamedTuple):
    """The messages of one tick."""

    number: int
    payloads: TickPayloads
    changes: list[tuple[str, Any]]
    """Changes of the channel by persons: path and value."""
    scheduled: list[tuple[str, Any]]
    """Changes of the channel by the schedule: path and value."""
    attended: list[list[int]]
    """Robots that take part from this tick on, for each unscheduled change of participation, in order."""
    report: Report | None
    """The Report of this tick; most ticks have none."""


def read(path: Path, robots: int, version: int = schemas.VERSION) -> Iterator[LoggedTick]:
    """The ticks of a file of a log of this `version`; raises FesError, or an error of UNREADABLE."""
    is_older = version < schemas.VERSION
    for number, contents in itertools.groupby(_numbered(path), key=itemgetter(0)):
        payloads, changes = dict[str, list[bytes]](), {"person": list[tuple[str, Any]](), "schedule": []}
        attended: list[list[int]] = []
        report: Report | None = None
        events = 0
        for _, topic, content in contents:
            if not isinstance(content, bytes):
                payloads[topic] = _payloads(path, topic, content, number, robots)
            elif topic == "/report":
                try:
                    payload = protobuf.parse(messages_pb2.Report, content).payload
                    report = decode_report(older.renewed(payload) if is_older else payload)
                except MessageError as error:
                    raise FesError(f"{path}: tick {number}: {error}") from None
            elif (event := parsed(content))["tick"] == number:
                if (events := events + 1) > _MAX_EVENTS:
                    raise FesError(f"{path}: tick {number} has more than {_MAX_EVENTS:,} events")
                if event["what"] == "set":
                    changes[event["by"]].append((str(event["path"]), event["value"]))
                elif event["what"] == "present":
                    attended.append([int(robot) for robot in event["robots"]])
                    if not all(0 <= robot < robots for robot in attended[-1]):
                        raise FesError(f"{path}: tick {number}: a robot takes part that is not one of {robots}")
        for topic in _TEAM_TOPICS:
            if topic not in payloads:
                raise FesError(f"{path}: tick {number} has no message on {topic}")
        ordered = TickPayloads(*(payloads[topic] for topic in _TEAM_TOPICS))
        ordered = _renewed(ordered, number) if is_older else ordered
        yield LoggedTick(number, ordered, changes["person"], changes["schedule"], attended, report)


def _renewed(payloads: TickPayloads, number: int) -> TickPayloads:
    """The payloads of a tick of an older log, as this version has them."""
    return TickPayloads(
        [older.renewed_observation(payload, number) for payload in payloads.observations],
        [older.renewed(payload) for payload in payloads.beacons],
        [older.renewed(payload) for payload in payloads.commands],
    )


def _numbered(path: Path) -> Iterator[tuple[int, str, _TeamMessage | bytes]]:
    """Tick, topic and content of each message that is read; a tick begins with its Observations."""
    number = -1
    for topic, message in messages(path):
        kind = _TEAM_TOPICS.get(topic)
        content = message.data if kind is None else protobuf.parse(kind, message.data)
        if isinstance(content, Observations):
            next_number = _tick(content)
            if next_number < 0:
                raise FesError(f"{path}: a message on {topic} has no tick")
            if next_number == number:
                raise FesError(f"{path}: tick {number} has two messages on {topic}")
            number = next_number
        if topic != "/scenario" and number >= 0:
            yield number, topic, content


def _tick(message: _TeamMessage) -> int:
    """The tick of a message of all robots; -1 if it has none."""
    return message.tick if message.HasField("tick") else -1


def parsed(data: bytes) -> Any:
    """The value of a message in JSON; raises ValueError."""
    if len(data) > MAX_JSON:
        raise ValueError(f"a text of {len(data):,} bytes, more than {MAX_JSON:,}")
    return strict_json.loads(data)


def _payloads(path: Path, topic: str, message: _TeamMessage, number: int, robots: int) -> list[bytes]:
    """The payloads of a message, which must be of this tick and have one payload per robot."""
    if _tick(message) != number:
        raise FesError(f"{path}: tick {number}: the message on {topic} is of tick {_tick(message)}")
    payloads = list(message.payloads)
    if len(payloads) != robots:
        raise FesError(f"{path}: tick {number}: {topic} has {len(payloads)} payloads, there are {robots} robots")
    return payloads


def one_line(error: Exception) -> str:
    """An error of UNREADABLE in one line."""
    if isinstance(error, RecursionError):
        return "it is nested too deeply"
    return " ".join(f"{type(error).__name__}: {error}".split()) if isinstance(error, KeyError) else str(error)


def messages(path: Path, read: Collection[str] = TOPICS) -> Iterator[tuple[str, Message]]:
    """Topic and message of the topics that are `read`, in the order of the file.

    Of a file that was cut, up to its last complete chunk.
    """
    topics: dict[int, str] = {}
    for block in Reader(path):
        for record in block:
            if isinstance(record, Channel):
                topics[record.id] = record.topic if record.topic in read else ""
            elif isinstance(record, Message) and topics[record.channel_id]:
                yield topics[record.channel_id], record
