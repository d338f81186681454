"""log(x) and log(1 + x), by a polynomial in s = f / (2 + f) without a table.

x = 2^k (1 + f) with 1 + f from sqrt(1/2) to sqrt(2), and log(1 + f) = 2 atanh(s) = f - s (f - s^2 R(s^2)).
R has 7 coefficients, by Remez' exchange for the least relative error of the whole: 2^-59.
"""

import math

import numpy as np

from fes.arithmetic import exact
from fes.arithmetic.exponential import LN2_HIGH, LN2_LOW, exp
from fes.arrays.types import Bools, Floats, Ints

SERIES = (
    0.1479610463708204,
    0.15314035926270983,
    0.18183564862737678,
    0.22222198563570503,
    0.2857142874247384,
    0.39999999999414326,
    0.6666666666666734,
)

SMALLEST = math.ldexp(1.0, -1022)
"""Smallest normal number."""

_ROOT_HALF_BITS = 0x3FE6A09E667F3BCD  # of sqrt(1/2)
_TO_NORMAL, _NORMAL_SHIFT = math.ldexp(1.0, 54), -54


def log(x: Floats) -> Floats:
    """The natural logarithm, any shape; -inf for 0, and NaN for a negative number and for NaN."""
    normal = (x >= SMALLEST) & (x < np.inf)
    if np.logical_and.reduce(normal, axis=None):
        return combined(*split(x))
    return _of_any(np.asarray(x), normal)


def log1p(x: Floats) -> Floats:
    """log(1 + x), any shape, to relative precision also where x is small; 0.0 at both zeros.

    -inf for -1, and NaN for a number below -1 and for NaN.
    """
    shifted = x + 1.0
    normal = (shifted > 0.0) & (shifted < np.inf)
    if np.logical_and.reduce(normal, axis=None):
        return _log1p(x, shifted)
    return np.where(normal, _log1p(np.where(normal, x, 0.0), np.where(normal, shifted, 1.0)), log(shifted))


def _log1p(x: Floats, shifted: Floats) -> Floats:
    """log(1 + x), where `shifted` is 1 + x rounded, positive and finite."""
    k, f = split(shifted)
    is_exact = k == 0
    rest = np.where(is_exact, 0.0, (x - (shifted - 1.0)) / shifted)
    return combined(k, np.where(is_exact, x, f), rest)


def log_sum_exp(z: Floats) -> Floats:
    """log(1 + e^z), any shape, without overflow; NaN for NaN."""
    decay = exp(-np.abs(z))
    result: Floats = np.maximum(z, 0.0) + _log1p(decay, decay + 1.0)
    return result


def split(x: Floats) -> tuple[Ints, Floats]:
    """k and f of x = 2^k (1 + f), for normal positive x of any shape."""
    bits = exact.bits(x)
    k = (bits - _ROOT_HALF_BITS) >> exact.MANTISSA
    return k, exact.from_bits(bits - (k << exact.MANTISSA)) - 1.0


def combined(k: Ints | Floats, f: Floats, rest: Floats | float = 0.0) -> Floats:
    """k log 2 + log(1 + f) + a small rest, for 1 + f from sqrt(1/2) to sqrt(2), any shape."""
    s = f / (f + 2.0)
    z = s * s
    q = z * SERIES[0]
    q += SERIES[1]
    for coefficient in SERIES[2:]:
        q *= z
        q += coefficient
    q *= z
    q = f - q
    q *= s
    q -= k * LN2_LOW + rest
    q = f - q
    q += k * LN2_HIGH
    return q


def _of_any(x: Floats, normal: Bools) -> Floats:
    """The logarithm where not all numbers are normal."""
    subnormal = (x > 0.0) & (x < SMALLEST)
    known = np.where(normal | subnormal, x, 1.0) * np.where(subnormal, _TO_NORMAL, 1.0)
    k, f = split(known)
    result = combined(k + np.where(subnormal, _NORMAL_SHIFT, 0), f)
    result = np.where(normal | subnormal, result, np.nan)
    result = np.where(x == 0.0, -np.inf, result)
    return np.where(x == np.inf, np.inf, result)
