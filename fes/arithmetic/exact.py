"""Operations without a rounding error, of which the elementary functions are made."""

import numpy as np

from fes.arrays.types import Floats, Ints, read_only


def constants(*values: float) -> tuple[Floats, ...]:
    """Floats as arrays without an axis: numpy adds these in half the time of Python's own."""
    return tuple(read_only(np.array(value)) for value in values)


HALF, UNIT, TWO = constants(0.5, 1.0, 2.0)

(ROUND,) = constants(6755399441055744.0)  # 1.5 * 2**52
"""Added to a number below 2**51 in magnitude, it leaves the nearest integer in the last bits; ties go to even."""

ROUND_BITS = 0x4338000000000000
"""The bits of `ROUND`."""

BIAS, MANTISSA = 1023, 52
"""Bias of the exponent of a float, and number of its mantissa's bits."""

(_SPLIT,) = constants(134217729.0)  # 2**27 + 1


def bits(values: Floats) -> Ints:
    """The bits of numbers, as floats, in integers, any shape."""
    result: Ints = np.asarray(values, dtype=np.float64).view(np.int64)
    return result


def from_bits(values: Ints) -> Floats:
    """The floats with these bits, any shape."""
    result: Floats = values.view(np.float64)
    return result


def scaled(values: Floats | float, exponent: Ints) -> Floats:
    """values 2^exponent, shapes that broadcast: exact, and rounded once where the result is subnormal."""
    result: Floats = np.ldexp(values, exponent)
    return result


def product_error(a: Floats, b: Floats, product: Floats) -> Floats:
    """a b - product, where `product` is a b rounded (Dekker 1971); exact while nothing over- or underflows."""
    t = a * _SPLIT
    a_high = t - (t - a)
    a_low = a - a_high
    t = b * _SPLIT
    b_high = t - (t - b)
    b_low = b - b_high
    error: Floats = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return error
