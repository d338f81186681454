"""TOML from outside: tables of bounded depth and integers of bounded size, or an error in one line."""

import tomllib
from pathlib import Path
from typing import Any

from fes.errors import ScenarioError, reason
from fes.system import encoding
from fes.system.encoding import DEEPEST

LARGEST = 2**64
"""Exclusive bound of the size of integers. TOML promises 64 bits, and Python does not print very long integers."""


class Malformed(ValueError):
    """Text that is not TOML."""


def parse(text: str) -> dict[str, Any]:
    """The tables in a text; raises Malformed if it is not TOML and ValueError if it is too large, in one line."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise Malformed(f"is not valid TOML: {error}") from None
    except RecursionError:
        raise ValueError("is nested too deeply") from None
    except ValueError:  # from int(), which reads at most 4,300 digits, and from impossible dates
        raise ValueError("has a number or a date that is too large") from None
    check(tables)
    return tables


def read(path: Path) -> dict[str, Any]:
    """The tables of a file; raises ScenarioError."""
    try:
        return parse(encoding.read(path))
    except OSError as error:
        raise ScenarioError(str(path), f"cannot be read: {reason(error, with_file=False)}") from None
    except ValueError as error:
        raise ScenarioError(str(path), str(error)) from None


def check(value: object) -> None:
    """Raise ValueError if a value is nested too deeply or contains an integer of more than 64 bits."""
    waiting = [(value, 0)]
    while waiting:
        part, depth = waiting.pop()
        if depth > DEEPEST:
            raise ValueError("is nested too deeply")
        if isinstance(part, dict):
            waiting += [(value, depth + 1) for value in part.values()]
        elif isinstance(part, list):
            waiting += [(value, depth + 1) for value in part]
        elif isinstance(part, int) and not -LARGEST < part < LARGEST:
            raise ValueError(f"has an integer of {part.bit_length()} bits, more than 64")
