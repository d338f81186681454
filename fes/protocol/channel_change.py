"""Change: a person's request to the world to change the channel during a run. Effect: the result."""

import math
from typing import Any, NamedTuple

from fes.errors import MessageError
from fes.protocol import wire
from fes.system import strict_json

LONGEST = 4096
"""Longest value of a Change [characters of JSON]."""

LONGEST_EFFECT = 32 * LONGEST
"""Longest value of an Effect [characters of JSON]: defaults are filled in."""

LONGEST_PATH = 200
"""Longest path [characters]."""

DEEPEST_PATH = 8
"""Largest number of names in a path; each names a table or a field in the table before it."""


class ParameterChange(NamedTuple):
    """A request to set a field of the channel."""

    path: str
    """Field of the channel, by its dotted path."""
    value: Any
    """As in a scenario: a number, a string, a list or a table."""


class ChangeResult(NamedTuple):
    """The value of the field after the request."""

    path: str
    value: Any
    """The effective value of the field."""
    tick: int
    """First tick with this value."""
    optimal_separation: float
    """r* of the channel with this value [m]; NaN for a channel that has none."""
    unnoticed: bool = False
    """True if the robots do not notice the change, because they compute with the channel that they were given."""


def encode_change(message: ParameterChange) -> bytes:
    """The payload of a Change; raises MessageError for a value that JSON cannot hold."""
    try:
        text = strict_json.dumps(message.value, refuse=True)
    except (TypeError, ValueError):
        rule = "expects finite numbers, words, lists or tables"
        raise MessageError("Change", rule, str(message.value)) from None
    return wire.pack(message.path, text)


def decode_change(payload: bytes) -> ParameterChange:
    """The Change in a payload; raises MessageError."""
    path, value = wire.unpack("Change", payload, 2)
    return ParameterChange(_path("Change", path), _value("Change", value, LONGEST))


def encode_result(message: ChangeResult) -> bytes:
    """The payload of an Effect."""
    return wire.pack(message.path, strict_json.dumps(message.value), *message[2:])


def decode_result(payload: bytes) -> ChangeResult:
    """The Effect in a payload; raises MessageError."""
    name = "Effect"
    path, value, tick, optimal, unnoticed = wire.unpack(name, payload, 5)
    if not (type(optimal) is float and math.isnan(optimal)):
        wire.finite(name, (optimal,))
    wire.check(name, type(unnoticed) is bool, "unnoticed must be true or false", unnoticed)
    return ChangeResult(
        _path(name, path), _value(name, value, LONGEST_EFFECT), wire.tick(name, tick), optimal, unnoticed
    )


def _path(name: str, path: Any) -> str:
    wire.check(
        name, type(path) is str and 0 < len(path) <= LONGEST_PATH and path.isprintable(), "expects a field", path
    )
    wire.check(name, path.count(".") < DEEPEST_PATH, f"expects a field of at most {DEEPEST_PATH} names", path)
    return str(path)


def _value(name: str, text: Any, longest: int) -> Any:
    wire.check(name, type(text) is str and len(text) <= longest, "expects a value as JSON", text)
    try:
        return strict_json.loads(text)
    except (ValueError, RecursionError):
        wire.check(name, False, "expects a value as JSON", text)
