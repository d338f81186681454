"""Rounding to an integer, powers of two, and the errors of products, against Python's integers and fractions."""

from fractions import Fraction

import numpy as np

from fes.arithmetic import exact


def test_adding_the_rounding_number_leaves_the_nearest_integer_and_ties_go_to_even() -> None:
    values = np.concatenate([np.random.default_rng(18).uniform(-1e6, 1e6, 1000), np.arange(-20.0, 20.0) + 0.5])
    shifted = values + exact.ROUND
    expected = [round(value) for value in values.tolist()]
    assert (shifted - exact.ROUND).tolist() == expected
    assert (exact.bits(shifted) - exact.ROUND_BITS).tolist() == expected


def test_scaling_by_a_power_of_two_is_exact_over_all_normal_exponents() -> None:
    exponents = np.arange(-1022, 1023)
    assert [Fraction(value) for value in exact.scaled(1.75, exponents).tolist()] == [
        Fraction(7, 4) * Fraction(2) ** n for n in exponents.tolist()
    ]


def test_scaling_to_a_subnormal_number_rounds_once_to_the_nearest() -> None:
    values = np.random.default_rng(20).uniform(1.0, 2.0, 1000)
    expected = [float(Fraction(value) * Fraction(1, 2**1060)) for value in values.tolist()]
    assert exact.scaled(values, np.full(1000, -1060)).tolist() == expected


def test_bits_and_floats_are_inverse() -> None:
    values = np.array([0.0, -0.0, 1.5, -np.inf, 5e-324])
    assert exact.from_bits(exact.bits(values)).tobytes() == values.tobytes()
    assert exact.bits(np.array([1.0])).tolist() == [0x3FF0000000000000]


def test_a_product_and_its_error_are_the_exact_product() -> None:
    generator = np.random.default_rng(19)
    a, b = generator.normal(size=(2, 2000)) * 10.0 ** generator.uniform(-100.0, 100.0, (2, 2000))
    product = a * b
    error = exact.product_error(a, b, product)
    for x, y, rounded, rest in zip(*(values.tolist() for values in (a, b, product, error)), strict=True):
        assert Fraction(x) * Fraction(y) == Fraction(rounded) + Fraction(rest)
