"""Errors of floats in units in the last place (ulp), against mpmath with 120 bits."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import mpmath
import numpy as np

from fes.arrays.types import Floats

PRECISION = 120
"""Bits of a reference value; its own error is 2^-67 of an ulp."""


class Exact(NamedTuple):
    """Real numbers [n], each as a float and a fraction of its last place."""

    high: Floats
    """The nearest floats."""
    low: Floats
    """The rest [ulp]."""


def exact(function: Callable[..., Any], *arguments: Floats) -> Exact:
    """A function of mpmath at `arguments` [n] each."""
    with mpmath.workprec(PRECISION):
        values = [function(*map(mpmath.mpf, point)) for point in zip(*(a.tolist() for a in arguments), strict=True)]
        high = [float(value) for value in values]
        low = [float((value - nearest) / math.ulp(nearest)) for value, nearest in zip(values, high, strict=True)]
    return Exact(np.array(high), np.array(low))


def errors(values: Floats, truth: Exact) -> Floats:
    """|value - truth| in units in the last place of the float nearest to the truth [n]."""
    result: Floats = np.abs((values - truth.high) / np.spacing(np.abs(truth.high)) - truth.low)
    return result
