"""The team index and its target, against a second method, hand algebra and the settled table."""

import hashlib
import math
from itertools import combinations, permutations
from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from scipy.sparse.csgraph import connected_components, csgraph_from_dense, dijkstra

from fes.arrays.types import Floats
from fes.extension.context import SeededDraws, WorldContext
from fes.model import objective, outage
from fes.model.config import Configuration, FormationConfig, ObjectiveConfig
from fes.shapes import choice
from tests.support.configurations import BEST, OBJECTIVE, START, patch, ring, row
from world.config.radio import RadioConfig
from world.metrics import graphs
from world.metrics.best_separation import best_separation
from world.metrics.optimum import optimal_separation
from world.metrics.team import target
from world.metrics.team.team_index import MAX_ROBOTS, team_index

ROUNDING = 1e-12
"""Relative error of a few hundred roundings."""

Losses = Literal[0, 1]
RAYLEIGH = RadioConfig()
LATTICE = FormationConfig(configuration="lattice")


def context(preferences: ObjectiveConfig) -> WorldContext:
    return WorldContext(0.02, 2, preferences, SeededDraws(1))


def index_of(positions: Floats, preferences: ObjectiveConfig = OBJECTIVE) -> float:
    """F of robots at these positions, over the Rayleigh channel."""
    result = target.of_positions(positions, RAYLEIGH, context(preferences))
    assert result is not None
    return result.value


def by_search(positions: Floats, preferences: ObjectiveConfig) -> float:
    """F by its definition: Dijkstra in the team, and again in the team without each robot."""
    n = len(positions)
    r = np.hypot(*(positions[:, None] - positions).T)
    ln_c = np.log(-np.expm1(-((r / preferences.minimum_separation) ** 4)), where=r > 0.0, out=np.zeros((n, n)))
    w = (r / preferences.maximum_separation) ** 4 + 3e-7 * r**3
    w = np.where((r > 0.0) & (r <= 150.0), w, np.inf)

    def cost(kept: list[int]) -> float:
        routes = dijkstra(csgraph_from_dense(w[np.ix_(kept, kept)], null_value=np.inf))
        return float(routes[~np.eye(len(kept), dtype=bool)].mean())

    everybody = list(range(n))
    losses = [[robot for robot in everybody if robot != lost] for lost in everybody]
    teams = [everybody, *(losses if preferences.losses and n > 2 else [])]
    return math.exp(preferences.coverage_weight * float(ln_c.sum()) / n - max(map(cost, teams)))


@pytest.mark.parametrize("r", [1.0, 40.0, BEST, 100.0, 149.0])
@pytest.mark.parametrize("losses", [0, 1])
def test_the_team_index_of_two_robots_is_the_index_of_their_link(r: float, losses: Losses) -> None:
    preferences = ObjectiveConfig(losses=losses)
    pair, separation = np.array([(3.0, 4.0), (3.0 + r, 4.0)]), np.array([r])
    j = objective.preference(separation, preferences) * outage.reception_probability(separation, RAYLEIGH)
    assert index_of(pair, preferences) == pytest.approx(j[0], rel=ROUNDING)


@given(
    st.lists(st.tuples(st.floats(0.0, 300.0), st.floats(0.0, 300.0)), min_size=2, max_size=9),
    st.sampled_from([0, 1]),
    st.sampled_from([0.25, 1.0, 3.0]),
)
def test_the_index_of_any_team_is_that_of_its_definition(
    places: list[tuple[float, float]], losses: Losses, weight: float
) -> None:
    positions = np.array(places)
    nearest = min(float(np.hypot(*(first - second))) for first, second in combinations(positions, 2))
    if nearest < 1e-3:
        return  # the definition takes a logarithm of what double precision rounds to 0
    preferences = ObjectiveConfig(losses=losses, coverage_weight=weight)
    assert index_of(positions, preferences) == pytest.approx(by_search(positions, preferences), rel=1e-9, abs=1e-300)


def test_a_team_in_two_parts_and_a_team_at_one_place_have_the_index_0() -> None:
    assert index_of(np.array([(0.0, 0.0), (151.0, 0.0)])) == 0.0
    assert index_of(np.array([(0.0, 0.0), (60.0, 0.0), (60.0, 0.0)])) == 0.0
    assert index_of(row(80.0)[[0, 1, 2]]) == 0.0  # without the middle robot, 160 m
    assert index_of(row(80.0)[[0, 1, 2]], ObjectiveConfig(losses=0)) > 0.5


def test_coverage_and_delivery_are_the_factors_of_the_index() -> None:
    preferences = ObjectiveConfig(coverage_weight=2.0)
    result = target.of_positions(patch(71.26), RAYLEIGH, context(preferences))
    assert result is not None
    assert result.coverage**2 * result.delivery == pytest.approx(result.value, rel=ROUNDING)
    assert result.delivery == pytest.approx(0.733, abs=0.0005)  # settled, with the worst loss


@pytest.mark.parametrize("n", [0, 1, MAX_ROBOTS + 1])
def test_a_team_that_is_too_small_or_too_large_has_no_index(n: int) -> None:
    assert team_index(60.0 * np.arange(2.0 * n).reshape(n, 2), np.full((n, n), 0.9), ObjectiveConfig()) is None
    assert math.isnan(target.target(n, LATTICE, RAYLEIGH, context(ObjectiveConfig())))


def test_the_index_depends_neither_on_the_order_of_the_robots_nor_on_the_place_of_the_team() -> None:
    positions = patch(70.0)
    turned = positions @ np.array([(0.6, 0.8), (-0.8, 0.6)]) + 300.0
    shuffled = np.random.default_rng(1).permutation(turned)
    assert index_of(shuffled) == pytest.approx(index_of(positions), rel=ROUNDING)


@pytest.mark.parametrize(
    ("places", "value", "digits"),
    [(START, 0.006, 3), (row(BEST), 0.290, 3), (ring(BEST), 0.593, 3), (patch(BEST), 0.6768, 4)],
)
def test_the_studied_configurations_have_their_settled_index(places: Floats, value: float, digits: int) -> None:
    assert index_of(places) == pytest.approx(value, abs=0.5 * 10.0**-digits)


@pytest.mark.parametrize(
    ("n", "ratio"), [(2, 1.0), (3, 1.0477), (10, 1.0462), (13, 1.0382), (37, 1.0255), (100, 0.9996)]
)
def test_the_best_link_of_a_patch_is_longer_than_that_of_a_pair(n: int, ratio: float) -> None:
    circumstances = context(ObjectiveConfig())
    best = target.spacing(choice.shape("lattice", n, 1), RAYLEIGH, circumstances)
    assert best / BEST == pytest.approx(ratio, abs=0.5e-4)


@pytest.mark.parametrize(
    ("n", "value"), [(2, 0.8438), (3, 0.8253), (5, 0.7328), (10, 0.6894), (20, 0.6236), (50, 0.5070), (100, 0.4065)]
)
def test_the_target_of_a_team_is_the_settled_one(n: int, value: float) -> None:
    circumstances = context(ObjectiveConfig())
    assert target.target(n, LATTICE, RAYLEIGH, circumstances) == pytest.approx(value, abs=0.5e-4)
    assert target.target(n, FormationConfig(), RAYLEIGH, circumstances) == target.target(
        n, LATTICE, RAYLEIGH, circumstances
    )


def test_the_best_length_maximizes_the_index_of_its_shape_over_all_lengths() -> None:
    # beta counts hops and neighbors only, so the length is near the best, not at it.
    shape = choice.shape("lattice", 10, 1)
    best = target.spacing(shape, RAYLEIGH, context(ObjectiveConfig()))
    searched = minimize_scalar(lambda r: -index_of(r * shape.slots), bounds=(50.0, 90.0), method="bounded")
    assert index_of(best * shape.slots) == pytest.approx(-searched.fun, rel=1e-4)


def test_a_larger_smallest_separation_makes_the_links_longer_still() -> None:
    preferences = ObjectiveConfig(minimum_separation=100.0)
    circumstances = context(preferences)
    best = target.spacing(choice.shape("lattice", 10, 1), RAYLEIGH, circumstances)
    assert best / optimal_separation(preferences, RAYLEIGH) == pytest.approx(1.0975, abs=0.5e-4)
    assert target.target(10, LATTICE, RAYLEIGH, circumstances) == pytest.approx(0.1018, abs=0.5e-4)


@pytest.mark.parametrize("name", ["line", "ring", "ladder"])
def test_a_drawn_shape_has_a_target_of_its_own(name: Configuration) -> None:
    drawn = FormationConfig(configuration=name)
    value = target.target(10, drawn, RAYLEIGH, context(ObjectiveConfig()))
    assert 0.25 < value < target.target(10, LATTICE, RAYLEIGH, context(ObjectiveConfig()))


def test_offsets_have_a_target_for_the_robots_that_have_one_only() -> None:
    places = FormationConfig(configuration="offsets", offsets=[(0.0, 0.0), (1.0, 0.0), (0.5, 0.8660254037844386)])
    circumstances = context(ObjectiveConfig())
    assert target.target(3, places, RAYLEIGH, circumstances) == pytest.approx(0.8253, abs=0.5e-4)
    assert math.isnan(target.target(4, places, RAYLEIGH, circumstances))


@pytest.mark.parametrize("weight", [0.1, 0.5117, 1.0, 1.0052, 4.0])
@pytest.mark.parametrize("model", ["rayleigh", "logistic", "perfect"])
def test_the_weighted_optimum_is_that_of_a_search(weight: float, model: str) -> None:
    preferences, formula = ObjectiveConfig(), RadioConfig(model=model)

    def loss(r: float) -> float:
        separation = np.array([r])
        q = np.exp(-((r / 150.0) ** 4)) * outage.reception_probability(separation, formula)[0]
        return float(-np.log(-np.expm1(-((r / 50.0) ** 4))) - weight * np.log(q))

    searched = minimize_scalar(loss, bounds=(20.0, 149.0), method="bounded", options={"xatol": 1e-9})
    exact = best_separation(context(preferences), formula, weight)
    assert exact == pytest.approx(searched.x, abs=1e-5)  # the search compares values: half their digits

    grid = np.linspace(0.0, 400.0, 20_001)
    rows = list(zip(grid.tolist(), outage.reception_probability(grid, formula).tolist(), strict=True))
    dense = RadioConfig(model="table", rows=rows)
    assert best_separation(context(preferences), dense, weight) == pytest.approx(exact, abs=0.02)


def test_a_channel_known_by_pair_has_no_target(tmp_path_factory: pytest.TempPathFactory) -> None:
    trace = tmp_path_factory.mktemp("trace") / "trace.csv"
    trace.write_text("time,sender,receiver,decoded\n0,0,1,1\n", encoding="utf-8")
    checksum = hashlib.sha256(trace.read_bytes()).hexdigest()
    channel = RadioConfig(model="trace", trace=str(trace), trace_sha256=checksum)
    assert math.isnan(target.target(2, LATTICE, channel, context(ObjectiveConfig())))


@given(st.integers(1, 9), st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), max_size=16))
def test_the_rows_that_cut_are_those_whose_loss_leaves_more_parts(n: int, pairs: list[tuple[int, int]]) -> None:
    edges = {(min(pair), max(pair)) for pair in pairs if pair[0] != pair[1] and max(pair) < n}
    matrix = np.zeros((n, n))
    for a, b in edges:
        matrix[a, b] = matrix[b, a] = 1.0
    parts = connected_components(matrix)[0]
    alone = [not row.any() for row in matrix]
    expected = []
    for lost in range(n):
        kept = np.delete(np.arange(n), lost)
        remaining = connected_components(matrix[np.ix_(kept, kept)])[0] if n > 1 else 0
        if remaining > parts - alone[lost]:
            expected.append(lost)
    for order in (sorted(edges), sorted(edges, reverse=True)):
        ends = np.array(order, dtype=np.int64).reshape(-1, 2).T
        assert graphs.cut_rows(n, *ends).tolist() == expected


def test_a_deep_tree_is_searched_without_recursion() -> None:
    n = 20_000
    chain = np.arange(n - 1)
    assert np.array_equal(graphs.cut_rows(n, chain, chain + 1), np.arange(1, n - 1))


def test_every_permutation_of_a_small_team_has_one_index() -> None:
    positions = patch(71.26)[:4]
    values = [index_of(positions[list(order)]) for order in permutations(range(4))]
    assert max(values) - min(values) <= ROUNDING
