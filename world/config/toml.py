"""TOML from outside: tables of bounded depth and numbers of bounded length, or an error in one line."""

import tomllib
from typing import Any

from fes.system.encoding import DEEPEST

LARGEST = 2**64
"""No whole number reaches it: TOML promises 64 bits, and longer ones cannot even be printed."""


class Malformed(ValueError):
    """Text that is not TOML."""


def parse(text: str) -> dict[str, Any]:
    """The tables in a text; raises Malformed for what is not TOML, ValueError for what is too large; in one line."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise Malformed(f"is not valid TOML: {error}") from None
    except RecursionError:
        raise ValueError("is nested too deeply") from None
    except ValueError:  # of int(), which reads at most 4,300 digits, and of dates that no calendar has
        raise ValueError("has a number or a date that is too large") from None
    check(tables)
    return tables


def check(value: object) -> None:
    """Raise ValueError for what is nested too deeply, or has a whole number of more than 64 bits."""
    waiting = [(value, 0)]
    while waiting:
        one, depth = waiting.pop()
        if depth > DEEPEST:
            raise ValueError("is nested too deeply")
        if isinstance(one, dict):
            waiting += [(part, depth + 1) for part in one.values()]
        elif isinstance(one, list):
            waiting += [(part, depth + 1) for part in one]
        elif isinstance(one, int) and not -LARGEST < one < LARGEST:
            raise ValueError(f"has a whole number of {one.bit_length()} bits, more than 64")
