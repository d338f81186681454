"""The proof that a team stays connected, against scipy's spanning tree and fine steps of the way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import minimum_spanning_tree

from agents.configuration import connection
from fes.arrays import geometry
from fes.arrays.types import Floats
from tests.support.configuration_starts import distances, is_connected


def scattered(seed: int, n: int, width: float) -> Floats:
    return np.random.default_rng(seed).uniform(0.0, width, (n, 2))


@pytest.mark.parametrize("n", [2, 3, 10, 50])
def test_the_bottleneck_is_the_longest_edge_of_the_spanning_tree(n: int) -> None:
    positions = scattered(n, n, 300.0)
    distance = geometry.distances(positions)
    assert connection.bottleneck(distance) == minimum_spanning_tree(distance).toarray().max()


def test_a_robot_alone_needs_no_link() -> None:
    alone = np.zeros((1, 2))
    assert connection.bottleneck(geometry.distances(alone)) == 0.0
    assert connection.is_kept(alone, alone + 5.0, 140.0)


def test_the_reach_is_the_keep_range_unless_the_start_needs_a_longer_link() -> None:
    pair = np.array([(0.0, 0.0), (90.0, 0.0)])
    assert connection.reach(geometry.distances(pair), 140.0) == 140.0
    assert connection.reach(geometry.distances(2.0 * pair), 140.0) == 180.0 + connection.MARGIN


@given(st.integers(0, 10_000), st.integers(2, 12))
def test_a_way_that_is_kept_is_connected_at_each_of_its_points(seed: int, n: int) -> None:
    start, end = scattered(seed, n, 60.0 * np.sqrt(n)), scattered(seed + 1, n, 60.0 * np.sqrt(n))
    if connection.is_kept(start, end, 140.0):
        for share in np.linspace(0.0, 1.0, 101):
            # rounding of a position: 1e-13 m
            assert is_connected(distances(start + share * (end - start)), 140.0 + 1e-9)


def test_a_link_that_ends_between_two_points_of_the_check_does_not_count_there() -> None:
    # the ends are 200 m apart; one relay leaves the range of the first, then another one comes in range of the second
    start = np.array([(0.0, 0.0), (200.0, 0.0), (104.0, 80.0), (74.0, -80.0)])
    end = start + np.array([(0.0, 0.0), (0.0, 0.0), (20.0, 0.0), (20.0, 0.0)])
    shares = np.arange(connection.PIECES + 1) / connection.PIECES
    assert all(is_connected(distances(start + share * (end - start)), 140.0) for share in shares)
    assert not is_connected(distances(start + 0.55 * (end - start)), 140.0)
    assert not connection.is_kept(start, end, 140.0)


@pytest.mark.parametrize(("reach", "is_kept"), [(140.0, False), (210.0, True)])
def test_a_way_on_which_one_relay_leaves_before_another_arrives_is_not_kept(reach: float, is_kept: bool) -> None:
    start = np.array([(0.0, 0.0), (200.0, 0.0), (100.0, 0.0), (-100.0, 0.0)])
    end = np.array([(0.0, 0.0), (200.0, 0.0), (300.0, 0.0), (100.0, 0.0)])
    assert is_connected(distances(start), 140.0)
    assert is_connected(distances(end), 140.0)
    assert connection.is_kept(start, end, reach) == is_kept
