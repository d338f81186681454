"""Logs of real robots, read back within the bounds of `fes.recording.records`."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from fes.errors import FesError
from fes.model.config import AgentConfig
from fes.protocol import wire
from fes.recording import protobuf, reader, ticks
from fes.recording.layout import AT_ITS_END
from fes.recording.messages_pb2 import RobotStep
from fes.recording.robot_log.layout import EVENTS, HEADER, KIND, MAX_EVENTS, ROBOT_LOG, STEPS, Fix, Header, counted
from fes.system import fingerprint, strict_json

_TOPICS = (HEADER, STEPS, EVENTS)


class RecordedStep(NamedTuple):
    """The payloads of one tick of a robot."""

    number: int
    """Steps before it, lost ones included."""
    lost: int
    """Steps directly before it that are not in the log."""
    tick: int
    monotonic_ns: int
    """Monotonic clock of the robot's machine."""
    observation: bytes
    beacons: list[bytes]
    """Those of tick - 1 that its code received, in id order."""
    beacon: bytes
    command: bytes
    fix: Fix | None
    """The latest pose from its body, if it was recorded."""


class RecordedEvent(NamedTuple):
    """An event at a robot."""

    kind: str
    text: str
    monotonic_ns: int
    tick: int | None
    """Tick of the latest step; None before the first."""
    values: dict[str, Any]


@dataclass(frozen=True)
class RobotRecording:
    """The log of a robot; its contents are read anew from the file each time."""

    path: Path
    header: Header
    arithmetic: Mapping[str, str]
    """Arithmetic of the process that recorded it."""
    fes_version: str | None
    """Version of fes that recorded it, if it is known."""
    ended: str | None
    """Reason for the end; None if the log has no end."""
    count: int | None
    """Number of steps that the robot made, lost ones included; None if the log has no end."""

    def contents(self) -> Iterator[RecordedStep | RecordedEvent]:
        """Its steps and events in order; of a log without an end those in complete chunks. Raises FesError."""
        try:
            yield from _read(self.path, self.count)
        except ticks.UNREADABLE as error:
            raise FesError(
                f"{self.path}: a message is not what its topic promises: {ticks.one_line(error)}"
            ) from None

    def steps(self) -> Iterator[RecordedStep]:
        """Its steps, in order; raises FesError."""
        return (content for content in self.contents() if isinstance(content, RecordedStep))

    @property
    def origin(self) -> str:
        """Version of fes and arithmetic of the process that recorded it."""
        return fingerprint.origin(self.fes_version, self.arithmetic)

    @property
    def complaint(self) -> str | None:
        """Complaint about a log without an end, or without its last steps; None about a complete one."""
        count = last = 0
        for step in self.steps():
            count, last = count + 1, step.number + 1
        if self.count is None:
            return f"{self.path} has no end, its robot was killed or the file was cut: {count} steps are there"
        if self.count > last:
            return f"{self.path} lacks the last {counted(self.count - last)}: its writer was behind"
        return None

    @property
    def end(self) -> str | None:
        """Reason for an end before its time; None if it has no end, or ended when it should."""
        return None if self.ended == AT_ITS_END else self.ended


def is_robot_log(path: Path) -> bool:
    """True if a file begins as the log of a robot, of any format; raises FesError if it is not an MCAP file."""
    return next((topic for topic, _ in ticks.messages(path, (HEADER, *ticks.TOPICS))), "") == HEADER


def load(path: Path) -> RobotRecording:
    """The log of a robot, with at least one step; raises FesError in one line."""
    content = _header(path)
    if content.get("format") != ROBOT_LOG:
        number = f"{content.get('format')!r:.20}"
        raise FesError(f"{path} is a robot's log of format {number}; this fes reads format {ROBOT_LOG}")
    ended = reader.metadata(path)
    try:
        header = _parsed(content)
        fingerprint.text(content["arithmetic"])  # raises one of these errors if it is invalid
        version = content.get("versions", {}).get("fes")
        how, count = (ended["ended"], int(ended["steps"][:20])) if ended else (None, None)
        recording = RobotRecording(path, header, content["arithmetic"], version, how, count)
    except ValidationError as error:
        raise FesError(f"{path}: the settings of its robot: {_first(error)}") from None
    except ticks.UNREADABLE as error:
        raise FesError(f"{path}: its header or its end cannot be read: {ticks.one_line(error)}") from None
    if next(recording.steps(), None) is None:
        raise FesError(recording.complaint or f"{path}: the robot ended before its first step")
    return recording


def _header(path: Path) -> dict[str, Any]:
    """The first message of the log."""
    with suppress(ValueError, RecursionError):
        for topic, message in ticks.messages(path, _TOPICS):
            content = ticks.parsed(message.data) if topic == HEADER else None
            if isinstance(content, dict) and content.get("kind") == KIND:
                return content
            break
    raise FesError(f"{path} is not a log of a robot: it does not begin with its robot")


def _parsed(content: dict[str, Any]) -> Header:
    """The header in a table of JSON; raises an error of UNREADABLE."""
    config = AgentConfig.model_validate_json(strict_json.dumps(content["config"]))
    texts, numbers = (
        (content["run"], content["boot"]),
        (content["robot"], content["wall_ns"], content["monotonic_ns"]),
    )
    extensions, notes = content["extensions"], content["notes"]
    if not all(isinstance(text, str) for text in texts) or not all(type(number) is int for number in numbers):
        raise TypeError("its run and boot are texts, its robot and clocks are integers")
    if not 0 <= content["robot"] <= wire.MAX_ID:
        raise ValueError(f"its robot is from 0 to {wire.MAX_ID}, got {content['robot']}")
    if not isinstance(notes, dict) or not all(isinstance(entry, dict) for entry in extensions):
        raise TypeError("its notes are a table, its extensions are tables")
    return Header(texts[0], content["robot"], texts[1], config, *numbers[1:], extensions, notes)


def _first(error: ValidationError) -> str:
    """The first fault of settings, in one line."""
    fault = error.errors()[0]
    return " ".join(f"{'.'.join(map(str, fault['loc']))}: {fault['msg']}".split())[:200]


def _read(path: Path, count: int | None) -> Iterator[RecordedStep | RecordedEvent]:
    """The contents of a file; `count` is the number of steps that its end states. Raises FesError, or UNREADABLE."""
    number, tick, events = -1, -1, 0
    for topic, message in ticks.messages(path, _TOPICS):
        if topic == EVENTS:
            if (events := events + 1) > MAX_EVENTS + 1:
                raise FesError(f"{path}: after step {number} come more than {MAX_EVENTS:,} events")
            yield _event(ticks.parsed(message.data))
        elif topic == STEPS:
            step = protobuf.parse(RobotStep, message.data)
            if not step.HasField("tick"):
                raise FesError(f"{path}: a message on {topic} has no tick")
            if step.number <= number or step.tick <= tick:
                raise FesError(
                    f"{path}: after step {number} of tick {tick} comes step {step.number} of tick {step.tick}"
                )
            if count is not None and step.number >= count:
                raise FesError(f"{path}: step {step.number} is there, and its end is of {count} steps")
            yield _step(step, step.number - number - 1)
            number, tick, events = step.number, step.tick, 0


def _step(message: RobotStep, lost: int) -> RecordedStep:
    fix = None
    if message.HasField("fix"):
        fix = Fix(message.fix.stamp_ns, (message.fix.x, message.fix.y, message.fix.heading))
    payloads = message.observation, list(message.beacons), message.beacon, message.command
    return RecordedStep(message.number, lost, message.tick, message.monotonic_ns, *payloads, fix)


def _event(content: Any) -> RecordedEvent:
    kind, text, values = content["kind"], content["text"], content.get("values", {})
    if not isinstance(kind, str) or not isinstance(text, str) or not isinstance(values, dict):
        raise TypeError("kind and text of an event are texts, its values a table")
    return RecordedEvent(kind, text, int(content["monotonic_ns"]), content.get("tick"), values)
