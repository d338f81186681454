"""exp(x) and 1 - exp(-a), by a polynomial of degree 13 without a table.

x = n ln 2 + r with |r| <= 0.347, and exp(x) = 2^n + 2^n p with p = exp(r) - 1. ln 2 is in two parts, so that n times
the first is exact. Worst errors over a million points each: docs/explanation/digits.md.
"""

import numpy as np

from fes.arithmetic import exact
from fes.arrays.types import Floats, Ints

PER_LN2 = 1.4426950408889634
LN2_HIGH, LN2_LOW = 0.693147180369123816490, 1.90821492927058770002e-10
SERIES = (
    1.6059043836821613e-10,
    2.08767569878681e-09,
    2.505210838544172e-08,
    2.7557319223985893e-07,
    2.755731922398589e-06,
    2.48015873015873e-05,
    0.0001984126984126984,
    0.001388888888888889,
    0.008333333333333333,
    0.041666666666666664,
    0.16666666666666666,
    0.5,
)
"""1/13! to 1/2!."""

LEAST, MOST = -746.0, 710.0
"""Arguments of exp are clamped to these: exp(LEAST) is 0, and exp(MOST) is infinite."""

FARTHEST = 40.0
"""Arguments of 1 - exp(-a) are clamped to this: beyond it the result is 1."""


def exp(x: Floats) -> Floats:
    """e^x, any shape; infinite above 709.78, with numpy's warning of an overflow, and NaN for NaN."""
    return _power(*reduced(np.minimum(np.maximum(x, LEAST), MOST)))


def one_minus_exp(a: Floats) -> Floats:
    """1 - e^-a for a >= 0, any shape, to relative precision also where a is small; NaN for NaN."""
    return _complement(*reduced(np.maximum(np.negative(a), -FARTHEST)))


def exp_and_rise(x: Floats, a: Floats) -> tuple[Floats, Floats]:
    """e^x and 1 - e^-a of equal shapes, to the same bits as one by one, in the time of one."""
    both = np.empty((2, *x.shape))
    np.minimum(np.maximum(x, LEAST), MOST, out=both[0, ...])
    np.maximum(np.negative(a), -FARTHEST, out=both[1, ...])
    n, p = reduced(both)
    return _power(n[0], p[0]), _complement(n[1], p[1])


def _power(n: Ints, p: Floats) -> Floats:
    """2^n (1 + p)."""
    p += 1.0
    return exact.scaled(p, n)


def _complement(n: Ints, p: Floats) -> Floats:
    """1 - 2^n (1 + p)."""
    result: Floats = (1.0 - exact.scaled(1.0, n)) - exact.scaled(p, n)
    return result


def reduced(x: Floats) -> tuple[Ints, Floats]:
    """n and p of e^x = 2^n (1 + p), any shape."""
    t = x * PER_LN2
    t += exact.ROUND
    n = exact.bits(t) - exact.ROUND_BITS
    t -= exact.ROUND
    r = x - t * LN2_HIGH
    t *= LN2_LOW
    r -= t
    p = tail(r)
    p += r
    return n, p


def tail(r: Floats) -> Floats:
    """e^r - 1 - r for |r| <= 0.35, any shape."""
    q = r * SERIES[0]
    q += SERIES[1]
    for coefficient in SERIES[2:]:
        q *= r
        q += coefficient
    q *= r * r
    return q
