"""The connectivity-keeping potential: hand numbers, and the slope of its tension."""

import numpy as np
import pytest

from agents.rivals.connectivity import Connectivity, ConnectivityParameters
from tests.support.surroundings import around, context, geometry, pair

LAW = Connectivity(ConnectivityParameters(reach=150.0, gain=0.5), context(2))


def pull(separation: float, desired: float = 70.0) -> float:
    seen = around(pair(separation))
    formed = LAW.step(None, seen, geometry(seen, desired))
    assert formed.pull[0, 0] == -formed.pull[1, 0]
    return float(formed.pull[0, 0])


def test_the_pull_is_that_of_the_tension() -> None:
    # half way to the reach, y = R / 2: R/2 V' = 1/2 (3/2) / (1/4) y = 3 y; the gain is 1/2
    assert pull(110.0) == pytest.approx(0.5 * 3.0 * 40.0)
    assert pull(35.0) == pytest.approx(-0.5 * 3.0 * 35.0)
    assert pull(70.0) == 0.0


@pytest.mark.parametrize("separation", [75.0, 100.0, 140.0])
def test_a_long_link_is_pulled_by_the_slope_of_its_tension(separation: float) -> None:
    def tension(length: float) -> float:
        return (length - 70.0) ** 2 / (150.0 - length)

    slope = (tension(separation + 1e-4) - tension(separation - 1e-4)) / 2e-4
    assert pull(separation) == pytest.approx(0.5 * 80.0 / 2.0 * slope, rel=1e-6)


def test_the_pull_stays_finite_and_keeps_its_direction_beyond_the_reach() -> None:
    forces = LAW.force(np.array([1.0, 149.9, 151.0, 1e6]), np.full(4, 70.0))
    assert np.isfinite(forces).all()
    assert forces[0] < 0.0 < forces[1] <= forces[2] == forces[3]
    # at the bound, 9/10 of the room: 0.5 * 1/2 * 1.1 / 0.01 * 0.9 * 80 m
    assert forces[3] == pytest.approx(0.5 * 55.0 * 72.0)
