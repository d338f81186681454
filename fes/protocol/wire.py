"""Fields of a payload: packed with msgpack, and checked one by one when they are read.

Every payload is a msgpack array that begins with PROTOCOL. Lists of ids and of numbers travel as binary,
little-endian int32 and float64. Each function that reads a field takes the name of the message. It raises
MessageError for a wrong type, length or size, a number that is not finite, and ids that do not ascend.
"""

import math
import reprlib
import struct
import sys
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeVar

import msgpack
import numpy as np

from fes.arrays.types import Bytes, Floats, Ints
from fes.errors import MessageError

PROTOCOL = 4
"""Version of the messages: increase it with each change of a message, or of the mark beside one."""
MAX_PAYLOAD = 1 << 20
"""Longest payload that is decoded [bytes]."""

_PACKER = msgpack.Packer()  # it holds the interpreter's lock while it packs

T = TypeVar("T", bound=tuple[float, ...])

LONGEST_CACHED = 4096
"""Longest list of ids whose array is cached [bytes]."""

MAX_LIST = 100_000
"""Longest list of robots in a Join or a Welcome; no run has more robots."""

MAX_TICK = 2**53
MAX_ID = 2**31 - 1

MANY = 64
"""Numbers from this many on are checked as an array; fewer are checked faster one by one."""

_INT32, _FLOAT64 = np.dtype("<i4"), np.dtype("<f8")
_FEW_FLOAT64 = [struct.Struct(f"<{count}d") for count in range(MANY)]
_NO_NUMBERS: Floats = np.frombuffer(b"", _FLOAT64)
_NO_CODES: Bytes = np.frombuffer(b"", np.uint8)

TOO_LONG = f"longer than {MAX_PAYLOAD} bytes"
WRONG_VERSION = f"speaks protocol {PROTOCOL}, got version"
NOT_FINITE = "expects a finite number"
BAD_ID = "robot must be an integer from 0 to 2^31 - 1"


def pack(*fields: Any) -> bytes:
    """The payload of a message with these fields."""
    return _PACKER.pack((PROTOCOL, *fields))  # type: ignore[no-any-return]


def unpack(name: str, payload: bytes, count: int, optional: int = 0) -> list[Any]:
    """The `count` fields of a payload, after the version, and up to `optional` more."""
    if len(payload) > MAX_PAYLOAD:
        check(name, False, TOO_LONG, len(payload))
    try:
        fields = msgpack.unpackb(payload)
    except (ValueError, msgpack.UnpackException, RecursionError) as error:
        raise MessageError(name, f"is not msgpack ({type(error).__name__})") from None
    if type(fields) is not list or not fields:
        check(name, False, "expects an array", fields)
    if type(fields[0]) is not int or fields[0] != PROTOCOL:
        check(name, False, WRONG_VERSION, fields[0])
    if not count < len(fields) <= count + 1 + optional:
        check(name, False, f"expects {count} fields, got", len(fields) - 1)
    return fields[1:]  # type: ignore[no-any-return]


def check(name: str, holds: bool, rule: str, value: object) -> None:
    """Raise MessageError with the rule and the offending value unless the rule holds."""
    if not holds:
        shown = reprlib.repr(value)  # bounded in length and depth, for any value
        raise MessageError(name, rule, shown if len(shown) <= 60 else shown[:57] + "...")


def tick(name: str, value: Any) -> int:
    """A tick."""
    if type(value) is not int or not 0 <= value < MAX_TICK:
        check(name, False, "tick must be an integer from 0", value)
    return value  # type: ignore[no-any-return]


def robot_id(name: str, value: Any) -> int:
    """The id of a robot."""
    check(name, type(value) is int and 0 <= value <= MAX_ID, BAD_ID, value)
    return int(value)


def stamp(name: str, tick_: Any, robot: Any) -> tuple[int, int]:
    """A tick and the id of a robot."""
    if type(tick_) is int and type(robot) is int and 0 <= tick_ < MAX_TICK and 0 <= robot <= MAX_ID:
        return tick_, robot
    return tick(name, tick_), robot_id(name, robot)


def finite(name: str, values: T, most: float = sys.float_info.max) -> T:
    """A tuple of finite numbers, each within `most` of zero."""
    for value in values:
        if type(value) is not float or not -most <= value <= most:  # NaN is not
            is_finite = type(value) is float and math.isfinite(value)
            check(name, False, f"expects a number within {most:g} of zero" if is_finite else NOT_FINITE, value)
    return values


def robot_list(name: str, value: Any) -> tuple[int, ...]:
    """Ids of robots, ascending, at least one."""
    check(name, type(value) is list and 0 < len(value) <= MAX_LIST, "expects a list of robots", value)
    ids = tuple(robot_id(name, robot) for robot in value)
    check(name, all(low < high for low, high in pairwise(ids)), "robot ids must ascend", value)
    return ids


def flag(name: str, value: Any) -> bool:
    """True or False."""
    if value is not True and value is not False:
        check(name, False, "expects a flag", value)
    return value  # type: ignore[no-any-return]


def ids(name: str, blob: Any) -> Ints:
    """Ids, ascending [m]; the same bytes give the same array."""
    if type(blob) is not bytes or len(blob) % 4:
        check(name, False, "expects ids as int32", blob)
    ids = _ascending(blob) if len(blob) <= LONGEST_CACHED else _ascending.__wrapped__(blob)
    if ids is None:
        raise MessageError(name, "ids must ascend from 0")
    return ids


@lru_cache(maxsize=4096)
def _ascending(blob: bytes) -> Ints | None:
    """The ids in little-endian int32, or None if they do not ascend from 0.

    The same bytes give the same array, so that a set of ids which does not change keeps its identity.
    """
    ids = np.frombuffer(blob, _INT32).astype(np.int64)
    if len(ids) and (ids[0] < 0 or (ids[1:] <= ids[:-1]).any()):
        return None
    ids.flags.writeable = False
    return ids


def id_bytes(robots: Ints) -> bytes:
    """Ids [m] as a message carries them."""
    return robots.astype(_INT32).tobytes()


def numbers(name: str, blob: Any, count: int, most: float = sys.float_info.max) -> Floats:
    """Finite numbers [count], each within `most` of zero."""
    if type(blob) is not bytes or len(blob) != 8 * count:
        check(name, False, f"expects {count} float64", blob)
    if not blob:
        return _NO_NUMBERS
    values = np.frombuffer(blob, _FLOAT64)
    if not _are_within(blob, values, most):
        rule = f"numbers must be within {most:g} of zero" if np.isfinite(values).all() else "numbers must be finite"
        check(name, False, rule, values.tolist())
    return values


def _are_within(blob: bytes, values: Floats, most: float) -> bool:
    """True if the numbers in `blob`, which are also `values`, all are within `most` of zero; NaN is not."""
    if len(values) >= MANY:
        return bool(np.logical_and.reduce(np.abs(values) <= most))
    for value in _FEW_FLOAT64[len(values)].unpack(blob):  # noqa: SIM110 - a generator costs as much again
        if not -most <= value <= most:
            return False
    return True


def some_numbers(name: str, blob: Any, count: int, most: float = sys.float_info.max) -> Floats:
    """Finite numbers, at most `count` of them, each within `most` of zero."""
    if type(blob) is not bytes or len(blob) % 8 or len(blob) > 8 * count:
        check(name, False, f"expects at most {count} float64", blob)
    return numbers(name, blob, len(blob) // 8, most)


def some_bytes(name: str, blob: Any, count: int) -> bytes:
    """At most `count` bytes of any value."""
    if type(blob) is not bytes or len(blob) > count:
        check(name, False, f"expects at most {count} bytes", blob)
    return blob  # type: ignore[no-any-return]


def codes(name: str, blob: Any, count: int, highest: int) -> Bytes:
    """Small integers from 0 to `highest` [count]."""
    if type(blob) is not bytes or len(blob) != count:
        check(name, False, f"expects {count} codes", blob)
    if not blob:
        return _NO_CODES
    if max(blob) > highest:
        check(name, False, f"codes must be at most {highest}", blob)
    return np.frombuffer(blob, dtype=np.uint8)
