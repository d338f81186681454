"""atan2, by a reduction to an eighth of a turn and a polynomial without a table.

The angle of (x, y) is j pi/4 + s atan(q) with s = 1 or -1, j from 0 to 4, and 0 <= |q| <= tan(pi/8). The quotient q
is corrected by its own rounding error.
"""

import math

import numpy as np

from fes.arithmetic import exact
from fes.arrays.types import Bools, Floats

EIGHTH_HIGH, EIGHTH_LOW = 0.7853981633974483, 3.061616997868383e-17
"""pi/4; four times the first part is exact."""

BEND = 0.41421356237309503
"""tan(pi/8)"""

SERIES = (
    0.015180712401285002,
    -0.0334596562200217,
    0.04502886246280583,
    -0.05218233859488475,
    0.05876994030225937,
    -0.06666223777122599,
    0.07692282545950359,
    -0.09090908134583649,
    0.11111111087885486,
    -0.1428571428538302,
    0.19999999999997628,
    -0.33333333333333326,
)

SMALLEST_CORRECTED = math.ldexp(1.0, -400)
"""Smallest quotient of which the rounding error is a float."""


def atan2(y: Floats, x: Floats) -> Floats:
    """The angle of finite (x, y), shapes that broadcast, from -pi to pi [rad]; NaN for NaN.

    0 at the origin, with the sign of y: the sign of a zero x does not count.
    """
    across, along = np.abs(y), np.abs(x)
    num, den = _scaled(np.minimum(across, along), np.maximum(across, along))
    is_steep, is_bent = across > along, num > BEND * den
    q, error = _quotient(num, den, is_bent)
    z = q * q
    tail = z * SERIES[0]
    tail += SERIES[1]
    for coefficient in SERIES[2:]:
        tail *= z
        tail += coefficient
    tail *= z
    tail *= q
    tail += error - z * error
    is_back = x < 0.0
    eighths = np.where(is_bent, 1.0, np.where(is_steep, 2.0, 0.0))
    eighths = np.where(is_back, 4.0 - eighths, eighths)
    sign = np.where(is_steep != is_back, -1.0, 1.0)
    q, tail = sign * q, sign * tail
    base = eighths * EIGHTH_HIGH
    high = base + q
    result: Floats = high + (((base - high) + q) + (tail + eighths * EIGHTH_LOW))
    return np.copysign(result, y)


def _scaled(num: Floats, den: Floats) -> tuple[Floats, Floats]:
    """The same quotient with a denominator in [1, 2): nothing over- or underflows. 0/0 becomes 0/1."""
    share, exponent = np.frexp(den)
    return exact.scaled(num, 1 - exponent), np.where(den == 0.0, 1.0, share + share)


def _quotient(num: Floats, den: Floats, is_bent: Bools) -> tuple[Floats, Floats]:
    """q of num/den, or of (num - den)/(num + den) where that `is_bent`, and its rounding error."""
    less, more = den * is_bent, num * is_bent
    n, d = num - less, den + more
    n_low, d_low = num - (n + less), more - (d - den)
    q = n / d
    product = q * d
    error = ((((n - product) - exact.product_error(q, d, product)) + n_low) - q * d_low) / d
    return q, np.where(np.abs(q) > SMALLEST_CORRECTED, error, 0.0)
