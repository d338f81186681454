"""Each neighbor rule against its own definition, tried on every triple of robots."""

import numpy as np
import pytest

from agents.laws import neighbor_rules
from console.backends import inprocess
from fes.arrays.types import Bools, Floats
from fes.model.config import FormationConfig
from tests.support import laws, layouts
from tests.support import reference as witness
from tests.support.layouts import REACH, distance
from tests.support.loop import load

Pairs = set[tuple[int, int]]

LAYOUTS = [(n, width, seed) for n in (1, 2, 3, 10, 25) for width in (60.0, 250.0, 600.0) for seed in range(4)]


def found(rule: str, where: Floats, robots: list[int] | None = None, decoded: Bools | None = None) -> Pairs:
    """The pairs (robot, neighbor) that the code under test chooses."""
    known = layouts.hear(where, range(len(where)) if robots is None else robots, decoded=decoded)
    return layouts.pairs_of(known.edges, laws.rule(rule, known.edges.ids)(known))


def by_definition(rule: str, where: Floats, heard: Pairs) -> Pairs:
    """The same from the rule's definition; `heard`: (robot, peer) that a robot heard."""
    n, factor = len(where), 1.0 - FormationConfig().link_tolerance if rule.startswith("tolerant") else 1.0
    chosen = set()
    for i in range(n):
        mine = [j for j in range(n) if (i, j) in heard]
        if rule == "two_nearest":
            chosen |= {(i, j) for j in sorted(mine, key=lambda j: (distance(where, i, j), j))[:2]}
            continue
        for j in mine:
            closer = [
                k
                for k in mine
                if k != j and max(distance(where, i, k), distance(where, j, k)) < factor * distance(where, i, j)
            ]
            if rule == "disk" or not closer:
                chosen.add((i, j))
    return chosen


def all_heard(where: Floats) -> Pairs:
    n = len(where)
    return {(i, j) for i in range(n) for j in range(n) if i != j and distance(where, i, j) <= REACH}


@pytest.mark.parametrize("rule", laws.RULES)
@pytest.mark.parametrize(("n", "width", "seed"), LAYOUTS)
def test_a_rule_selects_links_as_defined(rule: str, n: int, width: float, seed: int) -> None:
    where = layouts.scatter(np.random.default_rng(seed), n, width)
    assert found(rule, where) == by_definition(rule, where, all_heard(where))


@pytest.mark.parametrize("rule", laws.RULES)
@pytest.mark.parametrize("seed", range(5))
def test_on_a_lattice_full_of_ties_a_rule_selects_links_as_defined(rule: str, seed: int) -> None:
    # whole meters: equal separations are equal to the bit
    where = (np.random.default_rng(seed).integers(0, 5, (12, 3)) * 40).astype(np.float64)
    assert found(rule, where) == by_definition(rule, where, all_heard(where))


@pytest.mark.parametrize("rule", laws.RULES)
@pytest.mark.parametrize("ratio", [0.1, 0.6])
@pytest.mark.parametrize("seed", range(5))
def test_an_unheard_peer_is_neither_neighbor_nor_witness(rule: str, seed: int, ratio: float) -> None:
    rng = np.random.default_rng(seed)
    # around the origin, where an unheard peer would be if its blank entry were taken for a place
    where = layouts.scatter(rng, 10, 200.0) - np.array([100.0, 100.0, 0.0])
    near = layouts.in_range(where, range(10))
    decoded = rng.random(len(near)) < ratio
    heard = layouts.pairs_of(near, decoded)
    assert 0 < len(heard) < len(near)
    assert found(rule, where, decoded=decoded) == by_definition(rule, where, heard)


def test_of_three_equally_near_peers_the_two_lowest_ids_are_the_two_nearest() -> None:
    where = layouts.poses([(0, 0), (0, -30), (30, 0), (-30, 0), (0, 31)])
    assert found("two_nearest", where, robots=[0]) == {(0, 1), (0, 2)}


def test_the_papers_fifth_robot_selects_the_first_two_of_its_four_equally_near_neighbors() -> None:
    where = layouts.poses([(0, 0), (25, 25), (50, 0), (25, -25), (25, 0)])
    assert found("two_nearest", where, robots=[4]) == {(4, 0), (4, 1)}


def test_an_equilateral_triangle_keeps_its_three_edges() -> None:
    where = layouts.poses([(0, 0), (30, 40), (50, 0), (80, 40)])  # sides 50, 50, 50 are exact
    assert distance(where, 0, 1) == distance(where, 0, 2) == 50.0
    assert {(0, 1), (0, 2)} <= found("relative_neighborhood", where)


@pytest.mark.parametrize("seed", range(20))
def test_the_relative_neighborhood_is_the_same_from_both_ends(seed: int) -> None:
    where = layouts.scatter(np.random.default_rng(seed), 20, 400.0)
    graph = found("relative_neighborhood", where)
    assert graph
    assert graph == {(j, i) for i, j in graph}


@pytest.mark.parametrize("seed", range(20))
def test_the_relative_neighborhood_connects_every_component_of_the_disk_graph(seed: int) -> None:
    # 25 robots in 500 m: about half of these disk graphs are connected
    where = layouts.scatter(np.random.default_rng(seed), 25, 500.0)
    disk, sparse = (
        witness.component_labels(25, sorted(pairs))
        for pairs in (all_heard(where), found("relative_neighborhood", where))
    )
    assert sparse == disk


@pytest.mark.parametrize("rule", laws.RULES)
@pytest.mark.parametrize("seed", range(5))
def test_a_robot_finds_the_same_neighbors_alone_in_its_crew_as_among_ten(rule: str, seed: int) -> None:
    where = layouts.scatter(np.random.default_rng(seed), 10, 220.0)
    together = found(rule, where)
    alone = [found(rule, where, robots=[i]) for i in range(10)]
    assert set().union(*alone) == together
    assert all(alone[i] == {pair for pair in together if pair[0] == i} for i in range(10))


def test_remembering_witnesses_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Robots that move, meet and part: with all triples and with remembered witnesses the same digest."""
    moving = load("hundred.toml", robots__count=40, robots__spacing=40.0, run__duration=3.0)
    with_all = inprocess.run(moving, "all")["digest"]
    monkeypatch.setattr(neighbor_rules, "FEW", 0)
    assert inprocess.run(moving, "remembered")["digest"] == with_all
