"""Pairs in range against all pairs, while robots move and the candidate list is made anew."""

from itertools import pairwise

import numpy as np
import pytest

from fes.arrays.types import Floats
from tests.support import layouts
from world.simulation import neighbor_list
from world.simulation.neighbor_list import Proximity

REACH = 100.0

Pairs = set[tuple[int, int]]


def brute_force(where: Floats) -> tuple[Pairs, Floats]:
    """All (i, j) in range, and the matrix of separations."""
    separation = np.hypot(where[:, None, 0] - where[None, :, 0], where[:, None, 1] - where[None, :, 1])
    near = (separation <= REACH) & ~np.eye(len(where), dtype=np.bool_)
    return set(zip(*(side.tolist() for side in np.nonzero(near)), strict=True)), separation


def walk(n: int, width: float, speed: float, ticks: int, seed: int) -> list[tuple[Floats, Proximity]]:
    """Robots that wander by up to `speed` a tick, and what was measured."""
    rng = np.random.default_rng(seed)
    where = layouts.scatter(rng, n, width) - np.array([width / 2, width / 2, 0.0])  # negative coordinates too
    velocity = rng.uniform(-speed, speed, (n, 2))
    measured: list[tuple[Floats, Proximity]] = []
    for _ in range(ticks):
        near = neighbor_list.measure(np.arange(n), where, REACH, measured[-1][1] if measured else None)
        measured.append((where, near))
        velocity = np.clip(velocity + rng.normal(0.0, 0.2 * speed, (n, 2)), -speed, speed)
        where = where + np.column_stack([velocity, np.zeros(n)])
    return measured


@pytest.mark.slow
@pytest.mark.parametrize(
    ("n", "width", "speed"), [(200, 1500.0, 2.0), (200, 600.0, 1.0), (65, 50.0, 4.0), (40, 300.0, 2.0)]
)
def test_the_pairs_in_range_are_those_that_a_search_of_all_pairs_finds(n: int, width: float, speed: float) -> None:
    measured = walk(n, width, speed, 100, seed=n)
    seen = set()
    for where, near in measured:
        expected, separation = brute_force(where)
        edges = near.edges
        assert layouts.pairs_of(edges) == expected
        assert len(edges) == len(expected)  # none twice
        assert near.separation[near.pair] == pytest.approx(separation[edges.rows, edges.peers], rel=1e-14)
        assert (np.diff(edges.keys) > 0).all()  # sorted by robot, then peer
        seen.add(len(expected))
    assert len(seen) > 3 or width < REACH / 2  # pairs came and went, unless all are always in range


def test_the_candidate_list_is_rarely_rebuilt() -> None:
    measured = walk(200, 1500.0, 2.0, 100, seed=1)
    lists = [near.candidates for _, near in measured]
    changes = sum(a is not b for a, b in pairwise(lists))
    # half the margin is 10 m, the fastest robot moves at most 2.8 m a tick
    assert 5 <= changes <= 99 / 3


def test_a_valid_list_is_kept_for_any_common_motion_of_the_robots() -> None:
    where = layouts.scatter(np.random.default_rng(2), 100, 900.0)
    first = neighbor_list.measure(np.arange(100), where, REACH, None)
    inside = where + np.array([6.0, 7.9, 0.0])  # 9.92 m of 10 m
    kept = neighbor_list.measure(np.arange(100), inside, REACH, first)
    assert kept.candidates is first.candidates
    moved = neighbor_list.measure(np.arange(100), where + np.array([6.0, 8.1, 0.0]), REACH, first)  # 10.08 m
    assert moved.candidates is not first.candidates


@pytest.mark.parametrize("n", [30, 200])
def test_the_edges_are_the_same_object_while_the_pairs_in_range_stay_the_same(n: int) -> None:
    measured = walk(n, 60.0 * n**0.5, 0.05, 100, seed=3)
    same = changed = 0
    for (_, before), (where, after) in pairwise(measured):
        assert after.candidates is before.candidates  # no robot moved 10 m
        if brute_force(where)[0] == layouts.pairs_of(before.edges):
            assert after.edges is before.edges
            same += 1
        else:
            assert after.edges is not before.edges
            changed += 1
    assert same > 10
    assert changed > 0


def test_range_is_inclusive() -> None:
    index, beyond = (
        neighbor_list.measure(np.arange(2), layouts.poses([(0, 0), (x, 0)]), REACH, None) for x in (100.0, 100.1)
    )
    assert layouts.pairs_of(index.edges) == {(0, 1), (1, 0)}
    assert len(beyond.edges) == 0


@pytest.mark.parametrize("n", [1, 70])
def test_robots_that_are_out_of_range_of_all_others_have_no_pairs(n: int) -> None:
    where = layouts.poses([(1e3 * k, -1e3 * k) for k in range(n)])
    near = neighbor_list.measure(np.arange(n), where, REACH, None)
    assert len(near.edges) == 0
    assert len(near.pair) == 0


@pytest.mark.parametrize(
    ("n", "width", "gone"),
    [(2, 50.0, 0), (30, 1000.0, 5), (100, 300.0, 0), (100, 300.0, 40), (70, 100_000.0, 0), (70, 100_000.0, 30)],
)
def test_the_smallest_separation_is_that_of_all_pairs_of_robots_present(n: int, width: float, gone: int) -> None:
    present = np.arange(n) >= gone
    so_far, nearest = np.inf, []
    for where, near in walk(n, width, 0.001 * width, 30, seed=n + gone):
        separation = brute_force(where[present])[1]
        nearest.append(float(separation[np.triu_indices(n - gone, 1)].min()))
        alone = neighbor_list.smallest(near, where, present, np.inf)
        assert alone == pytest.approx(nearest[-1], rel=1e-14)
        so_far = neighbor_list.smallest(near, where, present, so_far)
        assert so_far == pytest.approx(min(nearest), rel=1e-14)
    assert (min(nearest) > REACH) == (width > 10_000.0)  # so that robots that were never in range are searched too


def test_fewer_than_two_robots_have_no_smallest_separation() -> None:
    for n in (1, 3, 70):
        where = layouts.scatter(np.random.default_rng(n), n, 1e4)
        near = neighbor_list.measure(np.arange(n), where, REACH, None)
        for count in (0, 1):
            assert neighbor_list.smallest(near, where, np.arange(n) < count, np.inf) == np.inf
