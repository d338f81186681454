"""Powers: exact where they are exact, products against real powers, and special arguments."""

import math

import mpmath
import numpy as np
import pytest

from fes.arithmetic import elementary, power
from tests.support import ulps


@pytest.mark.parametrize("n", range(17))
def test_a_product_of_small_integers_is_exact(n: int) -> None:
    x = np.array([0.0, 1.0, 2.0, 3.0, 5.0, 7.0, 0.5, -2.0])
    assert elementary.product(x, n).tolist() == [float(value**n) for value in (0, 1, 2, 3, 5, 7, 0.5, -2)]
    assert elementary.power(x, float(n)).tobytes() == elementary.product(x, n).tobytes()


def test_the_order_of_products_is_that_of_the_bits_of_the_exponent() -> None:
    x = np.random.default_rng(7).uniform(0.1, 9.0, 100)
    assert elementary.product(x, 5).tobytes() == (((x * x) * (x * x)) * x).tobytes()
    assert elementary.product(x, 6).tobytes() == (((x * x) * x) * ((x * x) * x)).tobytes()
    assert elementary.power(x, 1.5).tobytes() == (x * np.sqrt(x)).tobytes()


@pytest.mark.parametrize("y", [0.5 * n for n in range(1, 2 * power.MOST_PRODUCTS + 1)])
def test_products_and_real_powers_agree(y: float) -> None:
    x = 10.0 ** np.random.default_rng(8).uniform(-9.0, 5.0, 300)
    # Each of up to y products and one root errs by half an ulp, which a binade's end doubles; a real power by 0.8.
    assert np.all(np.abs(elementary.power(x, y) / elementary.real_power(x, y) - 1.0) < (y + 2.0) * 2.0**-52)


@pytest.mark.parametrize("y", [-20.0, -1.0, -0.5, -1 / 3, 0.3, 1 / 3, math.pi, 16.5, 20.0])
def test_other_exponents_are_real_powers_within_an_ulp(y: float) -> None:
    x = 10.0 ** np.random.default_rng(9).uniform(-9.0, 5.0, 300)
    assert elementary.power(x, y).tobytes() == elementary.real_power(x, y).tobytes()
    assert ulps.errors(elementary.power(x, y), ulps.exact(mpmath.power, x, np.full_like(x, y))).max() < 1.0


def test_zero_to_the_power_of_products_is_zero_and_to_the_zeroth_one() -> None:
    assert [float(elementary.power(np.array([0.0]), y)[0]) for y in (0.5, 1.0, 2.5, 16.0, 0.0)] == [0.0] * 4 + [1.0]


@pytest.mark.parametrize("x", [0.0, -0.0, 5e-324, 1e-310])
def test_a_real_power_takes_smaller_numbers_as_the_smallest_normal_one(x: float) -> None:
    for y in (0.3, -0.3, 3.3):
        assert elementary.power(np.array([x]), y) == elementary.power(np.array([2.0**-1022]), y)


def test_a_real_power_takes_infinity_as_the_largest_float() -> None:
    x = np.array([np.inf, np.finfo(float).max])
    for y in (0.3, -0.3):
        first, second = elementary.power(x, y)
        assert first == second
        assert second == pytest.approx(float(mpmath.power(x[1], y)), rel=2.0**-52)


def test_one_to_any_power_and_any_number_to_the_power_of_zero_is_one() -> None:
    y = np.array([0.0, -0.0, 5e-324, 0.3, -7.7, 1e16, -1e16, 1e300])
    assert elementary.real_power(np.ones(len(y)), y).tolist() == [1.0] * len(y)
    x = np.array([2.0**-1022, 0.3, 7.7, 1e300])
    for zero in (0.0, -0.0, 5e-324, -1e-300):
        assert elementary.real_power(x, zero).tolist() == [1.0] * len(x)


def test_numbers_next_to_one_with_huge_exponents_are_within_an_ulp() -> None:
    x = np.array([1.0 + 2.0**-52, 1.0 - 2.0**-53, 1.0 + 2.0**-52, 1.0 - 2.0**-53, 1.0 + 1e-9])
    y = np.array([1e17, 1e17, -3e18, -6e18, -7e11])
    assert ulps.errors(elementary.real_power(x, y), ulps.exact(mpmath.power, x, y)).max() < 1.0


@pytest.mark.parametrize("y", [400.0, 1e4, 1e10, 1e16, 1e100, 1e300])
def test_a_power_beyond_the_floats_is_infinite_or_zero(y: float) -> None:
    with np.errstate(over="ignore"):
        assert elementary.real_power(np.array([10.0, 1e-300]), np.array([y, -y])).tolist() == [np.inf, np.inf]
        assert elementary.real_power(np.array([10.0, 1e-300]), np.array([-y, y])).tolist() == [0.0, 0.0]


def test_numpy_warns_of_an_overflow() -> None:
    with pytest.warns(RuntimeWarning, match="overflow"):
        power.power(np.array([1e300]), 1.1)
    with pytest.warns(RuntimeWarning, match="overflow"):
        power.power(np.array([1e300]), 2.0)


def test_shapes_broadcast() -> None:
    x, y = np.array([[2.0], [3.0]]), np.array([0.3, 0.7, 1.9])
    table = elementary.real_power(x, y)
    assert table.shape == (2, 3)
    assert table[1, 2] == elementary.real_power(np.array(3.0), 1.9)
