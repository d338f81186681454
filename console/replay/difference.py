"""Where two ticks differ: message, robot, field and both values."""

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
"""Fields of a Report that are of the machine or of the scenario's file, and not of the run."""
_OUTSIDE_SUMMARY = {"scenario", "backend", "wall_s", "ticks_per_s", "real_time_factor", "arithmetic"}
"""The same of a summary."""


class Difference(NamedTuple):
    """One field that is not the same to the bit."""

    tick: int
    message: str
    robot: int | None
    field: str
    first: Any
    second: Any

    def told(self, first: str, second: str) -> str:
        """In a line; `first` and `second` say where each value is.

        >>> Difference(7, "Command", 3, "twist.linear", 1.5, 2.5).told("in the log", "executed again")
        'tick 7, Command of robot 3: twist.linear is 1.5 in the log and 2.5 executed again'
        """
        whose = "" if self.robot is None else f" of robot {self.robot}"
        values = f"{self.first!r} {first} and {self.second!r} {second}"
        return f"tick {self.tick}, {self.message}{whose}: {self.field} is {values}"


def between(
    tick: int, one: TickPayloads, other: TickPayloads, robots: Container[int] | None = None
) -> Difference | None:
    """The first difference of two ticks: Observations before Beacons before Commands, the lowest robot first.

    With `robots`, of their messages only.
    """
    for message, mine, theirs in zip(_DECODERS, one, other, strict=True):
        if mine != theirs:
            if len(mine) != len(theirs):
                return Difference(tick, message, None, "number of robots", len(mine), len(theirs))
            for robot, pair in enumerate(zip(mine, theirs, strict=True)):
                if pair[0] != pair[1] and (robots is None or robot in robots):
                    return of_payloads(tick, message, robot, *pair)
    return None


def of_payloads(tick: int, message: str, robot: int, one: bytes, other: bytes) -> Difference:
    """The first field in which two payloads differ, which are not the same."""
    if not one or not other:
        return Difference(tick, message, robot, "payload", *("there" if it else "missing" for it in (one, other)))
    try:
        mine, theirs = _DECODERS[message](one), _DECODERS[message](other)
    except MessageError as error:
        return Difference(tick, message, robot, f"payload ({error})", one.hex(), other.hex())
    for field in mine._fields:
        found = _values(field, getattr(mine, field), getattr(theirs, field))
        if found is not None:
            return Difference(tick, message, robot, *found)
    return Difference(tick, message, robot, "encoding", one.hex(), other.hex())


def of_reports(one: Report, other: Report) -> Difference | None:
    """The first difference of two Reports, but for what is of the machine."""
    for field in one.__slots__:
        if field in _OUTSIDE:
            continue
        found = _values(field, getattr(one, field), getattr(other, field))
        if found is not None:
            return Difference(one.tick, "Report", None, *found)
    return None


def of_summaries(tick: int, one: dict[str, Any], other: dict[str, Any]) -> Difference | None:
    """The first difference of two summaries, but for what is of the machine and the name."""
    for key in dict.fromkeys([*one, *other]):
        mine, theirs = one.get(key), other.get(key)
        if key not in _OUTSIDE_SUMMARY and strict_json.dumps(mine) != strict_json.dumps(theirs):
            return Difference(tick, "summary", None, key, mine, theirs)
    return None


def _values(field: str, one: Any, other: Any) -> tuple[str, Any, Any] | None:
    """Name of the first part of a field that differs, and its values; None if nothing does."""
    if isinstance(one, np.ndarray):
        one, other = one.ravel().tolist(), other.ravel().tolist()
    if not isinstance(one, list | tuple):
        return None if _same(one, other) else (field, one, other)
    if len(one) != len(other):
        return f"length of {field}", len(one), len(other)
    parts = _PARTS.get(field)
    for at, pair in enumerate(zip(one, other, strict=True)):
        if not _same(*pair):
            return f"{field}.{parts[at]}" if parts else f"{field}[{at}]", *pair
    return None


def _same(one: Any, other: Any) -> bool:
    """Whether two values are the same to the bit: 0.0 is not -0.0, and NaN is NaN."""
    if isinstance(one, float) and isinstance(other, float):
        return struct.pack("<d", one) == struct.pack("<d", other)
    return bool(one == other)
