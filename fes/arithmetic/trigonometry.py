"""sin and cos together, by a reduction to a quarter turn and two polynomials without a table.

x = n pi/2 + r + e with |r| <= pi/4: pi/2 is in four parts, so that n times each of the first three is exact.
"""

import numpy as np

from fes.arithmetic import exact
from fes.arithmetic.polynomial import horner
from fes.arrays.types import Floats

(PER_QUARTER,) = exact.constants(0.6366197723675814)
QUARTER_HIGH, QUARTER_MIDDLE, QUARTER_LOW, QUARTER_LEAST = exact.constants(
    1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21, 8.4784276603689e-32
)
"""pi/2; the first three parts have 33 bits each."""

SINES = exact.constants(
    1.5896066701344328e-10,
    -2.5050745023009887e-08,
    2.755731360442391e-06,
    -0.00019841269829542273,
    0.008333333333322061,
    -0.1666666666666663,
)
COSINES = exact.constants(
    -1.1358423270163104e-11,
    2.0875698703482154e-09,
    -2.75573141639367e-07,
    2.4801587288799876e-05,
    -0.0013888888888872975,
    0.041666666666666595,
)

_SINE_SIGN, _COSINE_SIGN = np.array([1.0, 1.0, -1.0, -1.0]), np.array([1.0, -1.0, -1.0, 1.0])
"""By the number of quarter turns modulo 4."""

(TURN,) = exact.constants(6.283185307179586)

(MOST,) = exact.constants(1e6)
"""Largest magnitude [rad] with full precision; larger angles are wrapped first, by the float nearest to 2 pi."""


def sin_cos(x: Floats) -> tuple[Floats, Floats]:
    """sin(x) and cos(x), any shape [rad]; sin is 0.0 at both zeros, and NaN comes from NaN and the infinities."""
    if np.logical_or.reduce(np.abs(x) > MOST, axis=None):
        x = np.where(np.abs(x) > MOST, np.remainder(x, TURN), x)
    t = x * PER_QUARTER
    t = t + exact.ROUND
    n = exact.bits(t)
    t = t - exact.ROUND
    y, w = x - t * QUARTER_HIGH, t * QUARTER_MIDDLE
    high = y - w
    v = high - y
    low = ((y - (high - v)) - (w + v)) - t * QUARTER_LOW
    r = high + low
    e = ((high - r) + low) - t * QUARTER_LEAST
    z = r * r
    half = exact.HALF * z
    s = (horner(SINES, z) * z * r + (e - half * e)) + r
    w = exact.UNIT - half
    c = ((horner(COSINES, z) * (z * z) - r * e) + ((exact.UNIT - w) - half)) + w
    quarter = n & 3
    is_odd = (n & 1) == 1
    return np.where(is_odd, c, s) * _SINE_SIGN.take(quarter), np.where(is_odd, s, c) * _COSINE_SIGN.take(quarter)
