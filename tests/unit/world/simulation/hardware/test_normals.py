"""Normal numbers from sums of uniform ones: their moments, and what they depend on."""

import numpy as np
import pytest

from fes.arithmetic import draws
from tests.support import cores
from world.simulation.hardware.normals import Normals


def test_a_number_is_the_sum_of_twelve_uniform_numbers_minus_six() -> None:
    [number] = Normals(3, "x", 5, 2).of(17)[4, 1:].tolist()
    ids, terms = np.full(12, 4), np.arange(12, 24)
    uniform = draws.uniform_ticks(draws.key(3, "x"), 16, 4, ids, terms)[1]
    assert number == pytest.approx(sum(uniform.tolist()) - 6.0, abs=1e-14)  # twelve roundings of 12


def test_the_numbers_have_mean_zero_variance_one_and_no_correlation_over_robots_axes_and_ticks() -> None:
    normals = Normals(1, "x", 50, 3)
    numbers = np.stack([normals.of(tick) for tick in range(400)])
    count = numbers.size  # 60,000: four standard errors of each moment
    assert abs(numbers.mean()) < 4.0 / count**0.5
    assert abs((numbers**2).mean() - 1.0) < 4.0 * (2.0 / count) ** 0.5
    assert np.abs(numbers).max() <= 6.0
    for axis in range(3):
        neighbors = (numbers * np.roll(numbers, 1, axis)).mean()
        assert abs(neighbors) < 4.0 / count**0.5


def test_a_number_depends_neither_on_the_other_robots_nor_on_the_columns_nor_on_the_order_of_ticks() -> None:
    large, small = Normals(7, "x", 40, 3), Normals(7, "x", 2, 1)
    ticks = [0, 100, 3, 64, 63, 12345]
    of_large = {tick: large.of(tick)[:2, :1].tolist() for tick in reversed(ticks)}
    assert {tick: small.of(tick).tolist() for tick in ticks} == of_large
    assert Normals(7, "y", 2, 1).of(3).tolist() != of_large[3] != Normals(8, "x", 2, 1).of(3).tolist()


def test_the_numbers_are_the_same_without_the_core() -> None:
    expected = Normals(7, "x", 3, 3).of(5).tolist()
    with cores.only_numpy():
        assert Normals(7, "x", 3, 3).of(5).tolist() == expected
