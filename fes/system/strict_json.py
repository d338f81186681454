"""JSON according to its standard: no NaN, no Infinity. The only module that imports `json`."""

import json
import math
from typing import Any


def finite(value: Any) -> Any:
    """`value` with None for every number that is not finite, in lists, tuples and tables too.

    >>> finite({"a": [1.0, math.inf], "b": (math.nan, 2)})
    {'a': [1.0, None], 'b': [None, 2]}
    """
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    return value


def dumps(value: Any, indent: int | None = None, sort_keys: bool = False, refuse: bool = False) -> str:
    """`value` as JSON, with null for every number that is not finite.

    Raises TypeError for a value that JSON cannot hold; with `refuse`, ValueError for a number that is not finite.
    """
    return json.dumps(value if refuse else finite(value), indent=indent, sort_keys=sort_keys, allow_nan=False)


def loads(text: str | bytes) -> Any:
    """The value of a JSON text; raises ValueError, also for a number that is not finite, and for deep nesting.

    >>> loads('{"a": null}')
    {'a': None}
    >>> loads('{"a": NaN}')
    Traceback (most recent call last):
    ValueError: NaN is not a number of JSON
    """
    try:
        return json.loads(text, parse_constant=_refuse, parse_float=_number)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _number(word: str) -> float:
    number = float(word)
    return number if math.isfinite(number) else _refuse(word)


def _refuse(word: str) -> float:
    raise ValueError(f"{word[:40]} is not a number of JSON")
