"""Counts that come from two settings: how often one fits into the other. No other module makes such a division.

A ratio of two floats may be infinite, so each is bounded before it becomes an integer.
"""

import math
from functools import cache

import numpy as np

from fes.arrays.types import Floats, Ints

LARGEST = math.ldexp(1.0, 53)
"""Largest count: beyond it a float does not hold every whole number."""


def ratio(whole: float, part: float) -> float:
    """Number of times that `part` > 0 fits into `whole`; infinite beyond what a float can hold."""
    return whole / part if part > 0.0 else math.inf


def ticks(time: float, dt: float) -> int:
    """The tick nearest to a `time` [s], with ticks of `dt` [s].

    >>> ticks(0.5, 0.02), ticks(1e308, 1e-300)
    (25, 9007199254740992)
    """
    return round(min(ratio(time, dt), LARGEST))


def nearest(times: Floats, part: float) -> Ints:
    """Nearest number of parts of `part` [s] in each of `times` [s], which may be negative; any shape."""
    return np.floor(times / part + 0.5).astype(np.int64)


def ticks_of(period: float, dt: float) -> int:
    """Ticks of a `period` [s], at least one."""
    return max(1, ticks(period, dt))


@cache  # metrics ask at each tick
def ticks_within(time: float, dt: float) -> int:
    """Number of ticks after which a `time` [s] is over.

    >>> ticks_within(1.0, 0.3)
    4
    """
    return math.ceil(min(ratio(time, dt), LARGEST))


def steps(dt: float, longest: float) -> int:
    """Equal steps of a tick of `dt` [s], none longer than `longest` [s] up to rounding; at least one."""
    return max(1, math.ceil(min(ratio(dt, longest), LARGEST) - 1e-9))


def check(name: str, whole: float, part: float, most: float) -> None:
    """Raise ValueError in one line if `part` fits into `whole` more than `most` times."""
    if ratio(whole, part) > most:
        raise ValueError(f"{name} must be at most {most:g}, got {ratio(whole, part):g}")


def below(name: str, value: float, bound: float) -> None:
    """Raise ValueError in one line, the rule and then the value, unless the value is below the bound."""
    if value >= bound:
        raise ValueError(f"{name} must be below {bound:g}, got {value:g}: it cannot be stable")
