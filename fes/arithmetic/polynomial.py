"""Polynomials by Horner's scheme, each step of two roundings."""

from fes.arrays.types import Floats


def horner(coefficients: tuple[Floats, ...], z: Floats) -> Floats:
    """The polynomial of z, any shape, its highest coefficient first.

    There are at least two coefficients, made by `exact.constants`.
    """
    q = z * coefficients[0]
    if q.size == 1:  # numpy is slow in place there, to the same bits
        q = q + coefficients[1]
        for coefficient in coefficients[2:]:
            q = q * z + coefficient
        return q
    q += coefficients[1]
    for coefficient in coefficients[2:]:
        q *= z
        q += coefficient
    return q
