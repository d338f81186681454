"""Cells and centroids against circular segments and a sum over a grid."""

import math

import numpy as np
import pytest

from agents.rivals.voronoi import Voronoi, VoronoiParameters
from tests.support.surroundings import around, context, geometry, pair

RADIUS = 50.0


def law(n: int, rays: int = 4096) -> Voronoi:
    return Voronoi(VoronoiParameters(sensing_radius=RADIUS, gain=1.0, rays=rays), context(n))


def test_a_robot_that_hears_no_one_nearby_rests_in_its_disc() -> None:
    seen = around(pair(2.0 * RADIUS))
    formed = law(2).step(None, seen, geometry(seen, 60.0))
    # the rays add up to zero but for their rounding
    assert formed.pull == pytest.approx(np.zeros((2, 2)), abs=1e-10)
    assert formed.details is not None
    assert formed.details[:, 0] == pytest.approx([math.pi * RADIUS**2] * 2, rel=1e-12)


@pytest.mark.parametrize("separation", [10.0, 40.0, 80.0])
def test_a_peer_cuts_a_circular_segment_off(separation: float) -> None:
    seen = around(pair(separation))
    formed = law(2).step(None, seen, geometry(seen, 60.0))
    half = separation / 2.0
    chord = math.sqrt(RADIUS**2 - half**2)
    area = math.pi * RADIUS**2 - (RADIUS**2 * math.acos(half / RADIUS) - half * chord)
    assert formed.details is not None
    # the integrand has two kinks per cell: with 4096 rays the error is below (2 pi / 4096)^2 of its scale
    assert formed.details[0, 0] == pytest.approx(area, rel=1e-5)
    assert formed.pull[0] == pytest.approx([-2.0 / 3.0 * chord**3 / area, 0.0], rel=1e-5, abs=1e-9)
    assert formed.pull[1] == pytest.approx(-formed.pull[0], abs=1e-9)


@pytest.mark.parametrize(("rays", "error"), [(4096, 0.03), (64, 0.5)])
def test_the_centroids_of_many_robots_are_those_of_the_points_nearest_to_them(rays: int, error: float) -> None:
    positions = np.random.default_rng(4).uniform(0.0, 120.0, (8, 2))
    seen = around(positions)
    formed = law(8, rays).step(None, seen, geometry(seen, 60.0))
    side = np.arange(-55.0, 175.0, 0.25)
    points = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    distance = np.hypot(*(points[:, None] - positions).T).T
    nearest = distance.argmin(axis=1)
    for robot in range(8):
        cell = points[(nearest == robot) & (distance[:, robot] <= RADIUS)]
        # points lie 0.25 m apart; between 64 rays the edge of the cell is up to 5 m long
        assert positions[robot] + formed.pull[robot] == pytest.approx(cell.mean(axis=0), abs=error)


def test_robots_at_one_place_have_no_finite_bisector_and_do_not_fail() -> None:
    seen = around(np.zeros((2, 2)))
    formed = law(2).step(None, seen, geometry(around(pair(1.0)), 60.0))
    assert np.isfinite(formed.pull).all()
