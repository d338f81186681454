"""Plans of marks: least squares, no flapping, safe distances, connection, ties, contractions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from agents.configuration import planning
from agents.configuration.planning import CONTRACT, DIRECT, Plan, Settings
from fes.arrays.types import Floats
from fes.shapes.choice import shape
from tests.support.configuration_starts import STARTS, distances, is_connected

SPACING = 71.26
CLEARANCE = 6.0
LATTICE = Settings("lattice", (), 1, 6, 140.0, CLEARANCE)


def plan_of(positions: Floats, spacing: float = SPACING, how: Settings = LATTICE) -> Plan:
    """The plan of robots 0 to n - 1 at `positions` [n, 2] [m]."""
    marks = np.column_stack([positions, np.full(len(positions), spacing)]).astype(np.float32)
    return planning.plan(np.arange(len(positions)).tobytes(), marks.tobytes(), how)


def goals(plan: Plan) -> Floats:
    return plan.bases + plan.spacing * plan.offsets


def start(kind: str, n: int, seed: int) -> Floats:
    return STARTS[kind](n, np.random.default_rng([seed, n]))


def starts(*kinds: str) -> st.SearchStrategy[Floats]:
    """Starts of 2 to 12 robots."""
    return st.builds(start, st.sampled_from(kinds), st.integers(4, 12), st.integers(0, 10_000))


@pytest.mark.parametrize("n", [1, 2, 3, 7, 10, 20])
def test_the_plan_of_a_formed_patch_moves_no_robot(n: int) -> None:
    random = np.random.default_rng(n)
    patch = 71.26 * shape("lattice", n, 1).slots[random.permutation(n)] + random.uniform(-300.0, 300.0, 2)
    plan = plan_of(patch)
    assert plan.kind == DIRECT
    assert np.abs(goals(plan) - patch).max() < 2e-4  # m; float32 of 500 m
    assert plan.farthest(0.0) < 2e-4


def test_one_false_estimate_moves_the_spacing_by_a_bounded_length() -> None:
    patch = SPACING * shape("lattice", 10, 1).slots
    marks = np.column_stack([patch, np.full(10, SPACING)]).astype(np.float32)
    for estimate in (1e9, 140.0, 139.99):
        marks[3, 2] = estimate
        plan = planning.plan(np.arange(10).tobytes(), marks.tobytes(), LATTICE)
        assert plan.kind == DIRECT
        assert plan.spacing == pytest.approx(SPACING + (139.99 - SPACING) / 10, abs=1e-4)


def test_links_get_no_longer_than_the_keep_range() -> None:
    short = Settings("lattice", (), 1, 6, 60.0, CLEARANCE)
    plan = plan_of(50.0 * shape("lattice", 10, 1).slots, how=short)
    assert plan.kind == DIRECT
    assert plan.spacing == pytest.approx(59.99)


@settings(max_examples=30, deadline=None)
@given(starts("dense"))
def test_the_plan_of_a_small_team_has_the_least_sum_of_squared_ways(positions: Floats) -> None:
    plan = plan_of(positions)
    n, slots = len(positions), shape("lattice", len(positions), 1).slots
    sums = []
    for turn in 2.0 * np.pi * np.arange(6) / 6:
        turned = slots @ np.array([(np.cos(turn), np.sin(turn)), (-np.sin(turn), np.cos(turn))])
        costs = ((plan.marks[:, None] - plan.marks.mean(axis=0) - plan.spacing * turned) ** 2).sum(axis=2)
        sums.append(costs[linear_sum_assignment(costs)].sum())
    total = ((goals(plan) - plan.marks) ** 2).sum()
    assert plan.kind == DIRECT  # all are within reach of each other, and so is the patch
    # an orientation must be better by BETTER, and the tie term costs at most TIE a robot
    assert min(sums) - 1e-6 <= total <= min(sums) + planning.BETTER + planning.TIE * n


@settings(max_examples=40, deadline=None)
@given(starts("dense", "medium", "sparse"), st.floats(0.01, 0.95))
def test_a_plan_made_again_on_the_way_is_the_same(positions: Floats, share: float) -> None:
    first = plan_of(positions)
    if first.kind == DIRECT:
        second = plan_of(first.marks + share * (goals(first) - first.marks))
        assert second.kind == DIRECT
        # The total is the least of a finite set, and falls by as much as any other can fall. Another orientation
        # that was not admissible at the start may be so later: then the total is less.
        ways = [((goals(plan) - second.marks) ** 2).sum() for plan in (first, second)]
        if (first.slots != second.slots).any():
            assert ways[1] < ways[0] + planning.TIE * len(positions)
        else:
            assert np.abs(goals(first) - goals(second)).max() < 1e-3  # m; float32


@settings(max_examples=40, deadline=None)
@given(starts("dense", "medium", "sparse", "clusters", "clump"))
def test_robots_keep_their_distance_and_their_network_on_the_whole_way(positions: Floats) -> None:
    plan = plan_of(positions)
    begin, end = plan.marks, goals(plan)
    smallest = min(distances(begin).min(), plan.spacing)
    bottleneck = max(140.0, STARTS_REACH)
    for share in np.linspace(0.0, 1.0, 51):
        distance = distances(begin + share * (end - begin))
        assert is_connected(distance, bottleneck)
        # (p_i - p_j)(g_i - g_j) >= 0 up to the tie term gives 1/sqrt(2) of the smaller distance; a contraction of a
        # crowded team stops at its clearance
        if plan.kind == DIRECT:
            assert distance.min() >= smallest / np.sqrt(2.0) - 1e-3
        else:
            assert distance.min() >= min(smallest, CLEARANCE) - 1e-6


STARTS_REACH = 148.02
"""Longest link that a start needs, with the margin of the check [m]."""


@pytest.mark.parametrize("n", [5, 10, 20])
@pytest.mark.parametrize("offset", [(0.0, 0.0), (1024.0, -512.0), (-4096.0, 4096.0)])
def test_exact_ties_are_decided_alike_wherever_the_team_is(n: int, offset: tuple[float, float]) -> None:
    line = np.column_stack([64.0 * np.arange(n), np.zeros(n)])
    grid = np.stack([64.0 * (np.arange(n) % 4), 64.0 * (np.arange(n) // 4)], axis=1)
    for positions in (line, grid):
        plan, moved = plan_of(positions), plan_of(positions + np.array(offset))
        assert (plan.kind, plan.slots.tolist()) == (moved.kind, moved.slots.tolist())


def test_a_crowded_start_contracts_but_no_two_robots_get_closer_than_the_clearance() -> None:
    crowd = start("clump", 20, 6)
    plan = plan_of(crowd)
    assert plan.kind == CONTRACT
    assert plan.slots.tolist() == [planning.NO_SLOT] * 20
    share = CLEARANCE / distances(plan.marks).min()
    ways = plan.bases - plan.marks.mean(axis=0)
    assert ways == pytest.approx(max(0.5, share) * (plan.marks - plan.marks.mean(axis=0)), abs=1e-9)


@pytest.mark.parametrize("seed", [0, 9])
def test_a_team_that_cannot_contract_tries_finer_orientations(seed: int) -> None:
    crowd = start("clump", 20, seed)
    spread = 1.05 * CLEARANCE / distances(crowd).min() * crowd
    tight = spread / 1.1
    single = LATTICE._replace(orientations=1)
    assert plan_of(spread, how=single).kind == CONTRACT
    plan = plan_of(tight, how=single)
    slots = shape("lattice", 20, 1).slots
    assert plan.kind == DIRECT
    assert np.abs(plan.offsets - slots[plan.slots]).max() > 0.1


def test_a_team_that_cannot_contract_and_has_no_way_stays() -> None:
    crowd = start("clump", 20, 7)
    plan = plan_of(0.95 * CLEARANCE / distances(crowd).min() * crowd, how=LATTICE._replace(orientations=1))
    assert plan.kind == CONTRACT
    assert plan.farthest(0.0) < 1e-9


def test_the_spacing_is_the_mean_of_the_marked_estimates() -> None:
    marks = np.array([(0.0, 0.0, 70.0), (60.0, 0.0, 80.0)], dtype=np.float32)
    plan = planning.plan(np.array([3, 8]).tobytes(), marks.tobytes(), LATTICE)
    assert plan.ids.tolist() == [3, 8]
    assert plan.spacing == 75.0
    assert distances(goals(plan))[0, 1] == pytest.approx(75.0, abs=1e-12)


def test_the_longest_way_counts_the_dither() -> None:
    patch = 75.0 * shape("lattice", 10, 1).slots
    plan = plan_of(patch, 70.0)
    assert plan.farthest(5.0) < 1e-4
    assert plan.farthest(0.0) == pytest.approx(5.0 * shape("lattice", 10, 1).reach, abs=1e-4)


@pytest.mark.parametrize("name", ["line", "ring", "ladder", "offsets"])
def test_each_shape_is_a_goal(name: str) -> None:
    places = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    how = Settings(name, places if name == "offsets" else (), 1, 6, 140.0, CLEARANCE)
    plan = plan_of(start("dense", 4, 1), how=how)
    reached, wanted = distances(goals(plan)), 71.26 * distances(shape(name, 4, 1, how.offsets).slots)
    assert np.sort(reached[np.triu_indices(4, 1)]) == pytest.approx(np.sort(wanted[np.triu_indices(4, 1)]), abs=1e-4)
