"""The assignment with the least sum, against scipy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import linear_sum_assignment

from agents.configuration import assignment
from fes.arrays.types import Floats


def least(costs: Floats) -> float:
    """The least sum, by scipy."""
    return float(costs[linear_sum_assignment(costs)].sum())


def assigned(costs: Floats) -> float:
    """The sum of the assignment, which is one of each row to another column."""
    columns = assignment.least_sum(costs)
    assert sorted(columns.tolist()) == list(range(len(costs)))
    return float(costs[np.arange(len(costs)), columns].sum())


@given(st.integers(1, 9).flatmap(lambda n: arrays(np.float64, (n, n), elements=st.floats(-1e5, 1e5))))
def test_the_sum_is_the_least(costs: Floats) -> None:
    assert assigned(costs) == pytest.approx(least(costs), abs=1e-8)  # roundings of 9 sums of 1e5


@given(st.integers(1, 9).flatmap(lambda n: arrays(np.float64, (n, n), elements=st.integers(0, 3))))
def test_the_sum_is_the_least_where_many_assignments_are_equal(costs: Floats) -> None:
    assert assigned(costs) == least(costs)


@pytest.mark.parametrize("n", [1, 2, 10, 50, 100])
def test_the_sum_is_the_least_for_squared_distances_of_teams(n: int) -> None:
    random = np.random.default_rng(n)
    first, second = random.uniform(0.0, 500.0, (2, n, 2))
    costs = ((first[:, None] - second) ** 2).sum(axis=2)
    assert assigned(costs) == pytest.approx(least(costs), rel=1e-13)


@given(st.integers(1, 9).flatmap(lambda n: arrays(np.float64, (n, n), elements=st.floats(0.0, 1e5))))
def test_the_bound_is_never_above_the_sum(costs: Floats) -> None:
    assert assignment.at_least(costs) <= assigned(costs) + 1e-9
