"""The covered area against an independent program, hand geometry, and a sum over slices."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.arrays.types import Floats
from tests.support.configurations import STUDIED, row
from world.metrics.team.coverage import covered_area

RADIUS = 50.0
DISC = math.pi * RADIUS**2
ROUNDING = 1e-12
"""Relative error of a few hundred roundings."""


def lens(distance: float) -> float:
    """Area [m^2] that two discs share, by the formula for circular segments."""
    half = distance / 2.0
    return 2.0 * RADIUS**2 * math.acos(half / RADIUS) - 2.0 * half * math.sqrt(RADIUS**2 - half**2)


def lattice(spacing: float) -> Floats:
    """A robot and its six neighbors on the triangular lattice."""
    angle = math.pi / 3.0 * np.arange(6)
    return spacing * np.vstack([np.zeros((1, 2)), np.column_stack([np.cos(angle), np.sin(angle)])])


def sum_of_slices(positions: Floats, step: float) -> float:
    """The area from the covered length of vertical slices, `step` [m] apart; the length is exact.

    At each end of a disc the length rises as 2 sqrt(2 R x). There the midpoint rule is wrong by at most
    0.42 sqrt(2 R) step^1.5: 0.21 is the largest |zeta(-1/2, x)| for x in [0, 1].
    """
    low, high = positions[:, 0].min() - RADIUS, positions[:, 0].max() + RADIUS
    x = np.arange(low + step / 2.0, high, step)[:, None]
    half = np.sqrt(np.maximum(RADIUS**2 - (x - positions[:, 0]) ** 2, 0.0))
    bottom, top = positions[:, 1] - half, positions[:, 1] + half
    order = np.argsort(bottom, axis=1)
    bottom, top = np.take_along_axis(bottom, order, 1), np.take_along_axis(top, order, 1)
    before = np.column_stack([np.full(len(x), -np.inf), np.maximum.accumulate(top, axis=1)[:, :-1]])
    return float(np.maximum(top - np.maximum(bottom, before), 0.0).sum()) * step


def error_of_slices(robots: int, step: float) -> float:
    """Bound on the error [m^2] of `sum_of_slices`: two ends per disc, and the kinks where circles meet."""
    return robots * (0.84 * math.sqrt(2.0 * RADIUS * step**3) + 4.0 * step**2)


@pytest.mark.parametrize("name", STUDIED)
def test_the_studied_configurations_cover_their_known_areas(name: str) -> None:
    expected = STUDIED[name]
    assert covered_area(expected.positions, RADIUS) / 1e4 == pytest.approx(expected.hectares, abs=0.005)


def test_no_robot_covers_nothing_and_one_covers_its_disc() -> None:
    assert covered_area(np.zeros((0, 2)), RADIUS) == 0.0
    assert covered_area(np.array([[3.0, -4.0]]), RADIUS) == pytest.approx(DISC, rel=ROUNDING)


@pytest.mark.parametrize("distance", [1e-12, 1e-3, 20.0, 50.0, 99.0, 99.9999999])
@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 2.0, math.pi, 4.0])
def test_two_discs_cover_their_sum_without_their_lens(distance: float, angle: float) -> None:
    pair = distance * np.array([(0.0, 0.0), (math.cos(angle), math.sin(angle))])
    assert covered_area(pair, RADIUS) == pytest.approx(2.0 * DISC - lens(distance), rel=ROUNDING)


@pytest.mark.parametrize("distance", [2.0 * RADIUS, 2.0 * RADIUS + 1e-9, 1e3, 1e9])
def test_tangent_and_separate_discs_cover_their_sum(distance: float) -> None:
    for angle in np.linspace(0.0, 6.0, 101):  # some of these tangents are rounded to an overlap, others to a gap
        pair = distance * np.array([(0.0, 0.0), (math.cos(angle), math.sin(angle))])
        assert covered_area(pair, RADIUS) == pytest.approx(2.0 * DISC, rel=ROUNDING)


def test_robots_at_one_place_cover_it_once() -> None:
    places = row(60.0)
    doubled = np.vstack([places, places[3:7], -0.0 * places[:2]])
    assert covered_area(doubled, RADIUS) == covered_area(places, RADIUS)
    assert covered_area(np.array([(0.0, 0.0), (-0.0, 0.0)]), RADIUS) == pytest.approx(DISC, rel=ROUNDING)


def test_the_area_common_to_three_discs_counts_once() -> None:
    side = RADIUS  # then the three discs share a Reuleaux triangle
    triangle = side * np.array([(0.0, 0.0), (1.0, 0.0), (0.5, math.sqrt(0.75))])
    reuleaux = (math.pi - math.sqrt(3.0)) / 2.0 * side**2
    assert covered_area(triangle, RADIUS) == pytest.approx(3.0 * DISC - 3.0 * lens(side) + reuleaux, rel=ROUNDING)


def test_a_hole_is_not_covered() -> None:
    angle = 2.0 * math.pi * np.arange(12) / 12.0
    side = 80.0  # only neighbors overlap, and the discs enclose a hole
    circle = side / (2.0 * math.sin(math.pi / 12.0)) * np.column_stack([np.cos(angle), np.sin(angle)])
    assert covered_area(circle, RADIUS) == pytest.approx(12.0 * (DISC - lens(side)), rel=ROUNDING)


def test_three_circles_may_meet_in_one_point() -> None:
    side = math.sqrt(3.0) * RADIUS  # each pair of neighbors shares a lens, and no three discs share an area
    assert covered_area(lattice(side), RADIUS) == pytest.approx(7.0 * DISC - 12.0 * lens(side), rel=ROUNDING)


@pytest.mark.parametrize("spacing", [1e-9, RADIUS / 2.0, RADIUS, 70.0])
def test_the_area_of_a_lattice_is_that_of_its_slices(spacing: float) -> None:
    positions = lattice(spacing)
    assert abs(covered_area(positions, RADIUS) - sum_of_slices(positions, 0.01)) < error_of_slices(7, 0.01)


coordinates = st.floats(-200.0, 200.0) | st.sampled_from([0.0, 25.0, 50.0, 100.0])


@given(st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=12))
def test_the_area_of_any_team_is_that_of_its_slices(places: list[tuple[float, float]]) -> None:
    positions = np.array(places)
    bound = error_of_slices(len(places), 0.05)
    assert abs(covered_area(positions, RADIUS) - sum_of_slices(positions, 0.05)) < bound


@pytest.mark.parametrize("side", [300.0, 2000.0])
def test_the_area_of_a_thousand_robots_is_that_of_its_slices(side: float) -> None:
    positions = np.random.default_rng(4).uniform(0.0, side, (1000, 2))
    step = 0.5
    assert abs(covered_area(positions, RADIUS) - sum_of_slices(positions, step)) < error_of_slices(1000, step)


def test_the_area_depends_neither_on_the_order_of_the_robots_nor_on_the_origin() -> None:
    generator = np.random.default_rng(5)
    positions = np.round(generator.uniform(0.0, 400.0, (100, 2)) * 1024.0) / 1024.0  # exact after the shift below
    area = covered_area(positions, RADIUS)
    assert covered_area(generator.permutation(positions), RADIUS) == area
    assert covered_area(positions + 2.0**30, RADIUS) == pytest.approx(area, rel=ROUNDING)
