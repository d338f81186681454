"""sin and cos at special angles, and beyond the range of full precision."""

import math

import mpmath
import numpy as np
import pytest

from fes.arithmetic import elementary, trigonometry
from tests.support import ulps


def test_tiny_angles_are_their_own_sine() -> None:
    x = np.array([0.0, -0.0, 5e-324, -5e-324, 1e-310, 1e-300, -1e-9])
    sine, cosine = elementary.sin_cos(x)
    assert sine.tolist() == x.tolist()
    assert cosine.tolist() == [1.0] * len(x)


def test_multiples_of_a_quarter_turn_are_within_an_ulp_next_to_the_zeros() -> None:
    x = np.arange(-1000.0, 1000.0) * (math.pi / 2)
    x = x[x != 0.0]
    sine, cosine = elementary.sin_cos(x)
    assert ulps.errors(sine, ulps.exact(mpmath.sin, x)).max() < 1.0
    assert ulps.errors(cosine, ulps.exact(mpmath.cos, x)).max() < 1.0
    assert float(elementary.sin_cos(np.array(math.pi))[0]) == 1.2246467991473532e-16  # pi less the float


def test_the_angles_nearest_to_zeros_are_within_an_ulp() -> None:
    # Floats up to a million that are closest to a multiple of pi/2: with pi/2 in three parts, two erred by 1.06 ulp.
    cosines = np.array([413441.44719405076, 229174.47169039503, 321307.9594422229])
    sines = np.array([826882.8943881015, 458348.94338079006, 916697.8867615801, 642615.9188844458])
    errors_of_cosines = ulps.errors(elementary.sin_cos(cosines)[1], ulps.exact(mpmath.cos, cosines))
    errors_of_sines = ulps.errors(elementary.sin_cos(sines)[0], ulps.exact(mpmath.sin, sines))
    assert errors_of_cosines.max() < 0.8
    assert errors_of_sines.max() < 0.8


def test_odd_multiples_of_an_eighth_turn_are_within_an_ulp() -> None:
    x = np.concatenate(
        [np.nextafter((2.0 * np.arange(-500.0, 500.0) + 1.0) * (math.pi / 4), end) for end in (-9e9, 9e9)]
    )
    sine, cosine = elementary.sin_cos(x)
    assert ulps.errors(sine, ulps.exact(mpmath.sin, x)).max() < 1.0
    assert ulps.errors(cosine, ulps.exact(mpmath.cos, x)).max() < 1.0


def test_sin_is_odd_and_cos_even_to_the_bit() -> None:
    x = np.random.default_rng(10).uniform(0.0, 2e6, 3000)
    (sine, cosine), (back, same) = elementary.sin_cos(x), elementary.sin_cos(-x)
    inside = x <= trigonometry.MOST
    assert back[inside].tobytes() == (-sine[inside]).tobytes()
    assert same[inside].tobytes() == cosine[inside].tobytes()


def test_both_lie_between_minus_one_and_one() -> None:
    x = np.random.default_rng(11).uniform(-1e6, 1e6, 20_000)
    for result in elementary.sin_cos(x):
        assert np.abs(result).max() <= 1.0


@pytest.mark.parametrize("x", [1.0000001e6, -1.0000001e6, 1e7, -1e9, 1e16, 1e300])
def test_larger_angles_are_wrapped_by_the_float_nearest_to_a_turn(x: float) -> None:
    wrapped = math.fmod(x, 2.0 * math.pi)
    expected = elementary.sin_cos(np.array(wrapped + 2.0 * math.pi if wrapped < 0.0 else wrapped))
    assert [float(value) for value in elementary.sin_cos(np.array(x))] == [float(value) for value in expected]


def test_an_angle_beyond_the_range_errs_by_the_error_of_a_turn() -> None:
    x = np.random.default_rng(12).uniform(1e6, 1e9, 300)
    turns = x / (2.0 * math.pi)
    lacking = 2.4492935982947064e-16  # 2 pi less the nearest float
    for result, function in zip(elementary.sin_cos(x), (mpmath.sin, mpmath.cos), strict=True):
        truth = ulps.exact(function, x).high
        assert np.all(np.abs(result - truth) <= lacking * turns + 2.0**-52)


def test_a_large_angle_changes_no_bit_of_the_others() -> None:
    x = np.random.default_rng(13).uniform(-1e6, 1e6, 100)
    for result, expected in zip(elementary.sin_cos(np.append(x, 1e8)), elementary.sin_cos(x), strict=True):
        assert result[:100].tobytes() == expected.tobytes()


def test_infinity_has_no_sine() -> None:
    with np.errstate(invalid="ignore"):
        assert np.all(np.isnan(elementary.sin_cos(np.array([np.inf, -np.inf]))))
