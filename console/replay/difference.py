"""Differences between two ticks: message, robot, field and both values."""

import struct
from collections.abc import Callable, Container
from typing import Any, NamedTuple

import numpy as np

from fes.errors import MessageError
from fes.protocol import messages
from fes.protocol.report import Report
from fes.recording.layout import TickPayloads
from fes.system import strict_json

_DECODERS: dict[str, Callable[[bytes], Any]] = {
    "Observation": messages.decode_observation,
    "Beacon": messages.decode_beacon,
    "Command": messages.decode_command,
}
_PARTS = {"pose": ("x", "y", "heading"), "twist": ("linear", "angular")}
_OUTSIDE = {"scenario", "elapsed", "ticks_per_s", "alive", "late"}
"""Fields of a Report that describe the machine or the scenario's file, not the run."""
_OUTSIDE_SUMMARY = {"scenario", "backend", "wall_s", "ticks_per_s", "real_time_factor", "arithmetic", "model_free"}
"""Keys of a summary that describe the machine or the scenario's file, not the run."""


class Difference(NamedTuple):
    """A field that differs by at least a bit."""

    tick: int
    message: str
    robot: int | None
    field: str
    first: Any
    second: Any

    def describe(self, first: str, second: str) -> str:
        """The difference in a line; `first` and `second` name the origins of the values.

        >>> Difference(7, "Command", 3, "twist.linear", 1.5, 2.5).describe("in the log", "executed again")
        'tick 7, Command of robot 3: twist.linear is 1.5 in the log and 2.5 executed again'
        """
        owner = "" if self.robot is None else f" of robot {self.robot}"
        values = f"{self.first!r} {first} and {self.second!r} {second}"
        return f"tick {self.tick}, {self.message}{owner}: {self.field} is {values}"


def between(
    tick: int, first: TickPayloads, second: TickPayloads, robots: Container[int] | None = None
) -> Difference | None:
    """The first difference of two ticks: Observations before Beacons before Commands, the lowest robot first.

    With `robots`, only the messages of these robots are compared. `is_model_free` of Commands is not compared.
    """
    for message, first_payloads, second_payloads in zip(_DECODERS, first, second, strict=True):
        if first_payloads != second_payloads:
            if len(first_payloads) != len(second_payloads):
                return Difference(tick, message, None, "number of robots", len(first_payloads), len(second_payloads))
            for robot, pair in enumerate(zip(first_payloads, second_payloads, strict=True)):
                if pair[0] == pair[1] or (robots is not None and robot not in robots):
                    continue
                if message != "Command" or not _is_of_other_process(*pair):
                    return of_payloads(tick, message, robot, *pair)
    return None


def _is_of_other_process(first: bytes, second: bytes) -> bool:
    """True for two Commands that differ at most in `is_model_free`, a statement about the robot's process."""
    if not first or not second:
        return False
    try:
        second_flag = messages.decode_command(second).is_model_free
        return messages.encode_command(messages.decode_command(first)._replace(is_model_free=second_flag)) == second
    except MessageError:
        return False


def of_payloads(tick: int, message: str, robot: int, first: bytes, second: bytes) -> Difference:
    """The first field in which two unequal payloads differ."""
    if not first or not second:
        return Difference(
            tick, message, robot, "payload", *("there" if payload else "missing" for payload in (first, second))
        )
    try:
        first_message, second_message = _DECODERS[message](first), _DECODERS[message](second)
    except MessageError as error:
        return Difference(tick, message, robot, f"payload ({error})", first.hex(), second.hex())
    for field in first_message._fields:
        difference = _values(field, getattr(first_message, field), getattr(second_message, field))
        if difference is not None:
            return Difference(tick, message, robot, *difference)
    return Difference(tick, message, robot, "encoding", first.hex(), second.hex())


def of_reports(first: Report, second: Report) -> Difference | None:
    """The first difference of two Reports, fields of the machine aside."""
    for field in first.__slots__:
        if field in _OUTSIDE:
            continue
        difference = _values(field, getattr(first, field), getattr(second, field))
        if difference is not None:
            return Difference(first.tick, "Report", None, *difference)
    return None


def of_summaries(tick: int, first: dict[str, Any], second: dict[str, Any]) -> Difference | None:
    """The first difference of two summaries, name and keys of the machine aside."""
    for key in dict.fromkeys([*first, *second]):
        first_value, second_value = first.get(key), second.get(key)
        if key not in _OUTSIDE_SUMMARY and strict_json.dumps(first_value) != strict_json.dumps(second_value):
            return Difference(tick, "summary", None, key, first_value, second_value)
    return None


def _values(field: str, first: Any, second: Any) -> tuple[str, Any, Any] | None:
    """Name and values of the first part of a field that differs; None if all are equal."""
    if isinstance(first, np.ndarray):
        first, second = first.ravel().tolist(), second.ravel().tolist()
    if not isinstance(first, list | tuple):
        return None if _same(first, second) else (field, first, second)
    if len(first) != len(second):
        return f"length of {field}", len(first), len(second)
    parts = _PARTS.get(field)
    for index, pair in enumerate(zip(first, second, strict=True)):
        if not _same(*pair):
            return f"{field}.{parts[index]}" if parts else f"{field}[{index}]", *pair
    return None


def _same(first: Any, second: Any) -> bool:
    """True if two values have equal bits: 0.0 differs from -0.0, and NaN equals NaN."""
    if isinstance(first, float) and isinstance(second, float):
        return struct.pack("<d", first) == struct.pack("<d", second)
    return bool(first == second)
