"""log(x), log(1 + x) and log(1 + e^z) at special arguments."""

import math

import mpmath
import numpy as np
import pytest

from fes.arithmetic import elementary
from tests.support import ulps


def test_the_logarithm_of_zero_is_minus_infinity_and_of_infinity_infinity() -> None:
    assert elementary.log(np.array([0.0, -0.0, np.inf])).tolist() == [-np.inf, -np.inf, np.inf]


@pytest.mark.parametrize("x", [-5e-324, -1.0, -1e300, -np.inf, np.nan])
def test_a_negative_number_has_no_logarithm(x: float) -> None:
    assert np.isnan(elementary.log(np.array([1.0, x]))).tolist() == [False, True]


def test_the_logarithm_of_one_is_zero() -> None:
    assert elementary.log(np.array([1.0])).tolist() == [0.0]


def test_every_power_of_two_is_within_an_ulp() -> None:
    x = 2.0 ** np.arange(-1074.0, 1024.0)
    assert ulps.errors(elementary.log(x), ulps.exact(mpmath.log, x)).max() < 1.0


def test_neighbors_of_the_ends_of_the_reduction_are_within_an_ulp() -> None:
    root, steps = math.sqrt(0.5), np.arange(-50.0, 51.0)
    x = np.concatenate([root + 2.0**-53 * steps, 2.0 * root + 2.0**-52 * steps, 1.0 + 2.0**-53 * steps])
    x = np.concatenate([x, [5e-324, 1e-310, np.nextafter(2.0**-1022, 0.0), 2.0**-1022, np.finfo(float).max]])
    x = x[x != 1.0]
    assert ulps.errors(elementary.log(x), ulps.exact(mpmath.log, x)).max() < 1.0


def test_special_numbers_change_no_bit_of_the_others() -> None:
    x = 10.0 ** np.random.default_rng(6).uniform(-300.0, 300.0, 1000)
    special = np.array([0.0, -1.0, np.nan, np.inf, 5e-324])
    assert elementary.log(np.concatenate([x, special]))[:1000].tobytes() == elementary.log(x).tobytes()
    x, special = np.minimum(x, 1e5) - 0.5, np.array([-1.0, -2.0, np.nan, np.inf, -np.inf])
    assert elementary.log1p(np.concatenate([x, special]))[:1000].tobytes() == elementary.log1p(x).tobytes()


def test_log1p_of_a_tiny_number_is_the_number() -> None:
    x = np.array([0.0, -0.0, 5e-324, -5e-324, 1e-310, 1e-300, -1e-300, 1e-17, -1e-17])
    assert elementary.log1p(x).tolist() == x.tolist()


def test_log1p_at_the_ends_of_its_domain() -> None:
    assert elementary.log1p(np.array([-1.0, np.inf])).tolist() == [-np.inf, np.inf]
    assert np.all(np.isnan(elementary.log1p(np.array([-1.0000000000000002, -2.0, -np.inf, np.nan]))))


def test_log1p_next_to_minus_one_and_of_huge_numbers_is_within_an_ulp() -> None:
    x = np.array([np.nextafter(-1.0, 0.0), -1.0 + 1e-15, 2.0**53, 1e16, 1e100, np.finfo(float).max])
    assert ulps.errors(elementary.log1p(x), ulps.exact(mpmath.log1p, x)).max() < 1.0


def test_log_sum_exp_is_log_2_at_zero_and_its_argument_where_that_is_large() -> None:
    z = np.array([0.0, -0.0, 40.0, 1e4, 1e300, np.inf])
    assert elementary.log_sum_exp(z).tolist() == [math.log(2.0), math.log(2.0), 40.0, 1e4, 1e300, np.inf]


def test_log_sum_exp_of_a_very_negative_number_is_its_exponential() -> None:
    z = np.array([-40.0, -709.0, -745.0, -1e300, -np.inf])
    assert elementary.log_sum_exp(z).tolist() == elementary.exp(z).tolist()
