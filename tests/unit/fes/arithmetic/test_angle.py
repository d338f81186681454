"""atan2 on the axes and diagonals, at zeros, and for extreme numbers."""

import math

import mpmath
import numpy as np
import pytest

from fes.arithmetic import elementary
from tests.support import ulps

SCALES = [1.0, 3.7, 5e-324, 1e-310, 2.0**-1022, 1e-200, 1e200, 1e308, float(np.finfo(float).max)]


def angle(y: float, x: float) -> float:
    return float(elementary.atan2(np.array(y), np.array(x)))


@pytest.mark.parametrize("scale", SCALES)
def test_axes_and_diagonals_are_the_nearest_floats(scale: float) -> None:
    around = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)]
    expected = [0, 1, 2, 3, 4, -3, -2, -1]
    with mpmath.workprec(120):
        nearest = [float(mpmath.pi * n / 4) for n in expected]
    assert [angle(scale * y, scale * x) for y, x in around] == nearest


def test_the_angle_of_the_origin_is_zero_with_the_sign_of_y() -> None:
    for y in (0.0, -0.0):
        for x in (0.0, -0.0):
            assert angle(y, x) == 0.0
            assert math.copysign(1.0, angle(y, x)) == math.copysign(1.0, y)


@pytest.mark.parametrize("x", SCALES)
def test_a_zero_y_has_the_sign_of_the_result(x: float) -> None:
    assert [angle(0.0, -x), angle(-0.0, -x)] == [math.pi, -math.pi]
    assert [math.copysign(1.0, angle(0.0, x)), math.copysign(1.0, angle(-0.0, x))] == [1.0, -1.0]


def test_the_angle_is_odd_in_y_to_the_bit() -> None:
    y, x = np.random.default_rng(14).uniform(-1.0, 1.0, (2, 3000))
    assert elementary.atan2(-y, x).tobytes() == (-elementary.atan2(y, x)).tobytes()


@pytest.mark.parametrize("exponent", [-900, -30, 1, 300, 1000])
def test_a_power_of_two_changes_no_bit(exponent: int) -> None:
    y, x = np.random.default_rng(15).uniform(-1.0, 1.0, (2, 3000))
    scaled = elementary.atan2(np.ldexp(y, exponent), np.ldexp(x, exponent))
    assert scaled.tobytes() == elementary.atan2(y, x).tobytes()


def test_extreme_quotients_are_within_an_ulp() -> None:
    y, x = (part.ravel() for part in np.meshgrid(SCALES, [*SCALES, *(-scale for scale in SCALES)]))
    truth = ulps.exact(mpmath.atan2, y, x)
    normal = truth.high != 0.0  # the others are far below the floats
    assert ulps.errors(elementary.atan2(y, x), truth)[normal].max() < 1.0
    assert np.all(elementary.atan2(y, x)[~normal] == 0.0)


def test_neighbors_of_the_ends_of_the_reduction_are_within_an_ulp() -> None:
    steps = 1.0 + 2.0**-52 * np.arange(-50.0, 51.0)
    y = np.concatenate([math.tan(math.pi / 8) * steps, steps, math.tan(3 * math.pi / 8) * steps])
    for x in (np.ones_like(y), -np.ones_like(y)):
        assert ulps.errors(elementary.atan2(y, x), ulps.exact(mpmath.atan2, y, x)).max() < 1.0


def test_nan_in_either_gives_nan() -> None:
    assert np.all(np.isnan(elementary.atan2(np.array([np.nan, 1.0, np.nan]), np.array([1.0, np.nan, 0.0]))))


def test_shapes_broadcast() -> None:
    assert elementary.atan2(np.ones((2, 1)), np.array([1.0, -1.0, 0.0])).tolist() == [
        [math.pi / 4, 3 * math.pi / 4, math.pi / 2]
    ] * 2  # fmt: skip
