"""Pulls and predicted places, against a numerical solution of the motion that they stand for."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from agents.configuration import approach
from agents.configuration.approach import Approach
from agents.configuration.planning import DIRECT, NO_SLOT, NONE
from fes.arrays.types import Floats

DITHER = 3.0, 2.0 * np.pi / 20.0
PLACES = np.array([(10.0, -20.0), (300.0, 50.0), (-7.0, 4.0)])


def of_three(rate: Floats) -> Approach:
    """Three robots on their way."""
    base, offset = np.array([(1.0, 2.0)] * 3), np.array([(-1.5, 0.0), (0.5, 0.9), (0.0, 0.0)])
    ones = np.ones(3)
    return Approach(np.full(3, DIRECT), np.arange(3), base, offset, 70.0 * ones, rate, 0.5 * ones)


@pytest.mark.parametrize("dither", [None, DITHER])
@pytest.mark.parametrize("rate", [1.0, 0.2, 0.05])
def test_the_predicted_place_is_where_the_motion_of_the_pull_ends(
    dither: tuple[float, float] | None, rate: float
) -> None:
    way, begin, period = of_three(np.full(3, rate)), np.array([3.0, 7.5, 0.0]), 2.0

    def speed(elapsed: float, flat: Floats) -> Floats:
        """(6) with the gain 2.0 multiplies the pull by it."""
        return 2.0 * approach.pull(way, flat.reshape(3, 2), begin + elapsed, dither, 2.0).ravel()

    exact = solve_ivp(speed, (0.0, period), PLACES.ravel(), rtol=1e-10, atol=1e-10).y[:, -1].reshape(3, 2)
    predicted = approach.predicted(way, PLACES, begin, period, dither, None)
    assert predicted == pytest.approx(exact, abs=1e-6)


def test_no_predicted_place_is_further_than_the_limit_allows() -> None:
    way = of_three(np.full(3, 1.0))
    free, limited = (approach.predicted(way, PLACES, np.zeros(3), 2.0, None, limit) for limit in (None, 5.0))
    assert np.hypot(*(limited - PLACES).T) == pytest.approx(np.minimum(np.hypot(*(free - PLACES).T), 10.0))
    assert np.hypot(*(free - PLACES).T).max() > 10.0


def test_a_robot_without_a_plan_stays_and_has_no_pull() -> None:
    none = approach.none(3)
    assert (none.kind.tolist(), none.slot.tolist()) == ([NONE] * 3, [NO_SLOT] * 3)
    assert approach.pull(none, PLACES, np.zeros(3), DITHER, 1.0).tolist() == [[0.0, 0.0]] * 3
    assert approach.predicted(none, PLACES, np.zeros(3), 2.0, DITHER, 5.0).tolist() == PLACES.tolist()


def test_the_numbers_of_robots_without_a_plan_do_not_share_their_memory() -> None:
    none = approach.none(3)
    none.spacing[0] = 7.0
    assert none.rate[0] == none.quality_weight[0] == 0.0


def test_the_goal_swings_with_the_dither() -> None:
    way, quarter = of_three(np.ones(3)), np.full(3, 5.0)
    pull = approach.pull(way, PLACES, quarter, DITHER, 1.0)
    assert pull == pytest.approx(way.base + 73.0 * way.offset - PLACES, abs=1e-12)


def test_robots_are_chosen_one_by_one() -> None:
    chosen = approach.where(np.array([True, False, True]), of_three(np.ones(3)), approach.none(3))
    assert chosen.kind.tolist() == [DIRECT, NONE, DIRECT]
    assert chosen.offset.tolist() == [[-1.5, 0.0], [0.0, 0.0], [0.0, 0.0]]
    assert chosen.rate.tolist() == [1.0, 0.0, 1.0]
