"""x^y: products and one square root where y is a multiple of 1/2, exp(y log x) in twice the precision elsewhere."""

import numpy as np

from fes.arithmetic import exact, exponential, logarithm
from fes.arithmetic.polynomial import horner
from fes.arrays.types import Floats

SERIES = exact.constants(
    0.13251319912287723,
    0.13250119072859887,
    0.1538709071966058,
    0.18181775666270608,
    0.2222222264678884,
    0.2857142856908592,
    0.4000000000000625,
    0.6666666666666666,
)
"""As `logarithm.SERIES`, with an error of 2^-66."""

LN2_HIGH, LN2_LOW = exact.constants(0.6931471805592082, 7.371002565167799e-13)
"""log 2 in two parts; the first has 40 bits."""

MOST_PRODUCTS = 16
"""Largest exponent that is a product."""

(LARGEST,) = exact.constants(1.7976931348623157e308)
"""Largest float."""

(MOST_REST,) = exact.constants(1e-9)
"""Bound of the second part of y log x: it is below 1e-12 where x^y is neither 0 nor infinite."""


def power(x: Floats, y: float) -> Floats:
    """x^y for x >= 0 of any shape and one exponent.

    A multiple of 1/2 from 0 to 16 is a product. Others take x as between the smallest normal number
    and the largest float; NaN for NaN.
    """
    if 0.0 <= y <= MOST_PRODUCTS and (2.0 * y) % 1.0 == 0.0:
        result = product(x, int(y))
        return result if y % 1.0 == 0.0 else result * np.sqrt(x)
    return real_power(np.minimum(np.maximum(x, logarithm.SMALLEST), LARGEST), y)


def product(x: Floats, n: int) -> Floats:
    """x^n for n >= 0, by squaring from the highest bit of n."""
    if n == 0:
        return np.ones_like(x)
    result = x
    for bit in bin(n)[3:]:
        result = result * result
        if bit == "1":
            result = result * x
    return result


def real_power(x: Floats, y: Floats | float) -> Floats:
    """x^y for normal positive x and |y| up to 1e300, any shapes that broadcast; NaN for NaN.

    Infinite above the largest float, with numpy's warning of an overflow.
    """
    k, f = logarithm.split(x)
    e = k + 0.0 * x  # NaN for NaN, which has an exponent too
    t = f + exact.TWO
    s = f / t
    product = s * t
    s_low = (((f - product) - exact.product_error(s, t, product)) - s * (f - (t - exact.TWO))) / t
    z = s * s
    q = (horner(SERIES, z) * z * s + exact.TWO * s_low) + e * LN2_LOW
    # log x = high + low
    whole, part = e * LN2_HIGH, exact.TWO * s
    total = whole + part
    low = ((whole - total) + part) + q
    high = total + low
    low = (total - high) + low
    # y log x = product + low
    exponents = np.asarray(y, dtype=np.float64)
    product = exponents * high
    low = exact.product_error(exponents, high, product) + exponents * low
    low = np.minimum(np.maximum(low, -MOST_REST), MOST_REST)
    return _exp(np.minimum(np.maximum(product, exponential.LEAST), exponential.MOST), low)


def _exp(x: Floats, low: Floats) -> Floats:
    """e^(x + low), for a `low` below 1e-12."""
    t = x * exponential.PER_LN2
    t = t + exact.ROUND
    n = exact.bits(t) - exact.ROUND_BITS
    t = t - exact.ROUND
    w, v = x - t * exponential.LN2_HIGH, t * exponential.LN2_LOW
    r = w - v
    r_low = ((w - r) - v) + low
    tail = exponential.tail(r)
    tail = tail + (r_low + r_low * (r + tail))
    first = exact.UNIT + r
    return exact.scaled(first + ((r - (first - exact.UNIT)) + tail), n)
