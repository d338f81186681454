"""exp(x) and 1 - exp(-a) at special arguments, and together."""

import mpmath
import numpy as np
import pytest

from fes.arithmetic import elementary, exponential
from tests.support import ulps

LARGEST = 709.782712893384
"""The largest float whose exponential is a float."""

SMALLEST = -745.1332191019411
"""The smallest float whose exponential is nearer to the smallest float than to 0."""


def test_exp_of_zero_is_one() -> None:
    assert elementary.exp(np.array([0.0, -0.0, 5e-324, -5e-324])).tolist() == [1.0] * 4


def test_exp_is_finite_up_to_the_logarithm_of_the_largest_float() -> None:
    x = np.array([709.0, 709.7, 709.78, LARGEST])
    assert np.all(ulps.errors(elementary.exp(x), ulps.exact(mpmath.exp, x)) < 1.0)


@pytest.mark.parametrize("x", [np.nextafter(LARGEST, np.inf), 710.0, 711.0, 1e300, np.inf])
def test_exp_of_more_is_infinite_and_numpy_warns(x: float) -> None:
    with pytest.warns(RuntimeWarning, match="overflow"):
        assert exponential.exp(np.array([x])).tolist() == [np.inf]


def test_exp_underflows_gradually() -> None:
    x = np.array([-708.0, -708.4, -709.0, -730.0, -744.0, -745.0, SMALLEST])
    result = elementary.exp(x)
    assert np.all(ulps.errors(result, ulps.exact(mpmath.exp, x)) < 1.0)
    assert result[-1] == 5e-324


@pytest.mark.parametrize("x", [np.nextafter(SMALLEST, -np.inf), -746.0, -747.0, -1e300, -np.inf])
def test_exp_of_less_is_zero(x: float) -> None:
    assert elementary.exp(np.array([x])).tolist() == [0.0]


def test_one_minus_exp_of_a_tiny_number_is_the_number() -> None:
    a = np.array([0.0, -0.0, 5e-324, 1e-310, 2.0**-1022, 1e-300, 1e-17])
    assert elementary.one_minus_exp(a).tolist() == a.tolist()


@pytest.mark.parametrize("a", [38.0, 40.0, 41.0, 1e4, 1e300, np.inf])
def test_one_minus_exp_of_a_large_number_is_one(a: float) -> None:
    assert elementary.one_minus_exp(np.array([a])).tolist() == [1.0]


def test_one_minus_exp_lies_between_0_and_1() -> None:
    a = 10.0 ** np.random.default_rng(4).uniform(-320.0, 3.0, 20_000)
    rise = elementary.one_minus_exp(a)
    assert rise.min() > 0.0
    assert rise.max() == 1.0


@pytest.mark.parametrize("shape", [(), (1,), (0,), (500,), (3, 7), (2, 3, 4)])
def test_both_together_have_the_bits_of_each_alone(shape: tuple[int, ...]) -> None:
    generator = np.random.default_rng(5)
    x, a = generator.uniform(-720.0, 700.0, shape), 10.0 ** generator.uniform(-20.0, 3.0, shape)
    x, a = np.asarray(x), np.asarray(a)
    fall, rise = elementary.exp_and_rise(x, a)
    assert np.asarray(fall).tobytes() == np.asarray(elementary.exp(x)).tobytes()
    assert np.asarray(rise).tobytes() == np.asarray(elementary.one_minus_exp(a)).tobytes()


def test_the_coefficients_are_the_floats_nearest_to_the_inverse_factorials() -> None:
    assert [float(1 / mpmath.factorial(n)) for n in range(13, 1, -1)] == pytest.approx(
        list(map(float, exponential.SERIES)), rel=3e-16
    )
