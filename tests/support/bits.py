"""Comparison to the bit: of arrays, and of everything that holds arrays."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

_MAGNITUDES = """0 1 0.5 2 5e-324 1e-310 2.2250738585072014e-308 1e-300 1e-17 1.1102230246251565e-16 1e6 1e12
4503599627370496 1e154 1e300 0.7071067811865476 709.78 709.79 745.13 745.2 746 40 1.7976931348623157e308 inf"""

SPECIAL = np.array([sign * float(word) for word in _MAGNITUDES.split() for sign in (1.0, -1.0)] + [np.nan])
"""Zeros of both signs, denormals, bounds of functions, huge numbers, infinities and NaN."""


def differing(first: Array, second: Array) -> Array:
    """True where two arrays of one shape and type differ; NaN of any payload equal each other."""
    assert (first.shape, first.dtype) == (second.shape, second.dtype), (first.shape, second.shape)
    if first.dtype != np.float64:
        return np.asarray(first != second)
    words = (np.ascontiguousarray(values).view(np.int64) for values in (first, second))
    unequal = np.not_equal(*words).reshape(first.shape)
    return np.asarray(unequal & ~(np.isnan(first) & np.isnan(second)))


def differences(first: object, second: object, what: str = "") -> list[str]:
    """The arrays in which two values differ, with the first difference of each."""
    ours, theirs = dict(_arrays(first, what)), dict(_arrays(second, what))
    assert ours.keys() == theirs.keys()
    found = []
    for name in ours:
        if ours[name].shape != theirs[name].shape:
            found.append(f"{name}: {ours[name].shape} and {theirs[name].shape}")
        elif (unequal := differing(ours[name], theirs[name])).any():
            place = tuple(np.argwhere(unequal)[0].tolist())
            values = f"{ours[name][place]!r} and {theirs[name][place]!r}"
            found.append(f"{name}: {np.count_nonzero(unequal)} of {unequal.size}, at {place} {values}")
    return found


def _arrays(value: object, name: str) -> Iterator[tuple[str, Array]]:
    """Every array in a value, with the path to it."""
    if isinstance(value, np.ndarray | np.generic | float | int):
        yield name, np.asarray(value)
    elif is_dataclass(value):
        for field in fields(value):
            yield from _arrays(getattr(value, field.name), f"{name}.{field.name}")
    elif hasattr(value, "_fields"):
        for field_name in value._fields:
            yield from _arrays(getattr(value, field_name), f"{name}.{field_name}")
    elif isinstance(value, tuple | list):
        for index, part in enumerate(value):
            yield from _arrays(part, f"{name}[{index}]")


def sprinkled(generator: np.random.Generator, values: Array, share: float) -> Array:
    """The values, a `share` of them replaced by special ones."""
    chosen = generator.random(values.shape) < share
    return np.where(chosen, generator.choice(SPECIAL, values.shape), values)
