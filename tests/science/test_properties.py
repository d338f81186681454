"""Properties on which the paper's argument rests, over the examples of hypothesis."""

import math

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from agents.laws import neighbor_rules, oracle
from agents.laws.neighbor_rules import Witnesses
from fes.arrays.types import Floats
from fes.model import outage
from fes.model.config import ChannelConfig, ObjectiveConfig
from tests.support import layouts
from tests.support.layouts import REACH, distance
from world.metrics.optimum import optimal_separation

channels = st.builds(
    ChannelConfig,
    reference_snr=st.floats(1e5, 1e9),
    spectral_efficiency=st.floats(0.5, 4.0),
    path_loss_exponent=st.floats(2.0, 4.5),
)
objectives = st.builds(
    ObjectiveConfig,
    minimum_separation=st.floats(20.0, 90.0),
    maximum_separation=st.floats(100.0, 300.0),
    shape_exponent=st.floats(1.0, 6.0),
)
# Positions on a grid of 1 m, so that ties are frequent and distances exact.
teams = st.lists(st.tuples(st.integers(0, 400), st.integers(0, 400)), min_size=2, max_size=14, unique=True)


def edges_of(where: Floats) -> set[tuple[int, int]]:
    known = layouts.hear(where, range(len(where)))
    return layouts.pairs_of(known.edges, neighbor_rules.relative_neighborhood(known, Witnesses(known.edges)))


def joined(n: int, edges: set[tuple[int, int]]) -> bool:
    """True if a graph is connected, by a walk over it."""
    reached, waiting = {0}, [0]
    while waiting:
        node = waiting.pop()
        new = {j for i, j in edges if i == node} - reached
        reached |= new
        waiting += new
    return len(reached) == n


@given(objective=objectives, channel=channels)
def test_the_index_lies_in_zero_to_one_and_rises_to_one_maximum_then_falls(
    objective: ObjectiveConfig, channel: ChannelConfig
) -> None:
    r = np.linspace(0.5, 400.0, 4000)
    J = oracle.FormulaIndex(objective, channel, "none")(r)
    assert ((J >= 0.0) & (J < 1.0)).all()
    steps = np.diff(J)
    steps = steps[np.abs(steps) > 1e-14]  # above rounding; J underflows to zero at large separations
    changes = np.flatnonzero(np.diff(np.sign(steps)))
    assert len(changes) == 1
    assert steps[0] > 0.0
    assert abs(r[int(np.argmax(J))] - optimal_separation(objective, channel)) <= 0.1  # the grid's step


@given(channel=channels, r=st.lists(st.floats(0.0, 1e3), min_size=2, max_size=30))
def test_outage_never_falls_with_the_separation(channel: ChannelConfig, r: list[float]) -> None:
    lost = outage.outage_probability(np.sort(np.array(r)), channel)
    assert (np.diff(lost) >= 0.0).all()
    assert ((lost >= 0.0) & (lost <= 1.0)).all()


@given(team=teams)
def test_the_relative_neighborhood_graph_is_symmetric_and_connected_whenever_the_disk_graph_is(
    team: list[tuple[int, int]],
) -> None:
    where = layouts.poses([(float(x), float(y)) for x, y in team])
    edges, n = edges_of(where), len(where)
    assert {(j, i) for i, j in edges} == edges
    disk = {(i, j) for i in range(n) for j in range(n) if i != j and distance(where, i, j) <= REACH}
    if joined(n, disk):
        assert joined(n, edges)


@given(team=teams, shuffle=st.randoms(use_true_random=False))
def test_the_relative_neighborhood_graph_does_not_depend_on_the_robots_ids(
    team: list[tuple[int, int]], shuffle: object
) -> None:
    """This holds even with ties, as its definition compares strictly."""
    where = layouts.poses([(float(x), float(y)) for x, y in team])
    order = list(range(len(team)))
    shuffle.shuffle(order)  # type: ignore[attr-defined]
    relabeled = {(order[i], order[j]) for i, j in edges_of(where[np.array(order)])}
    assert relabeled == edges_of(where)


@given(team=teams, shuffle=st.randoms(use_true_random=False))
def test_two_nearest_does_not_depend_on_the_ids_except_for_ties(team: list[tuple[int, int]], shuffle: object) -> None:
    where = layouts.poses([(float(x), float(y)) for x, y in team])
    lengths = [distance(where, i, j) for i in range(len(team)) for j in range(i)]
    assume(len(set(lengths)) == len(lengths))
    order = list(range(len(team)))
    shuffle.shuffle(order)  # type: ignore[attr-defined]

    def chosen(poses: Floats) -> set[tuple[int, int]]:
        known = layouts.hear(poses, range(len(poses)))
        return layouts.pairs_of(known.edges, neighbor_rules.two_nearest(known))

    assert {(order[i], order[j]) for i, j in chosen(where[np.array(order)])} == chosen(where)


@given(channel=channels, probability=st.floats(1e-6, 1.0 - 1e-6))
def test_range_and_outage_are_each_others_inverse(channel: ChannelConfig, probability: float) -> None:
    separation = outage.range_at_outage(probability, channel)
    back = float(outage.outage_probability(np.array([separation]), channel)[0])
    assert math.isclose(back, probability, rel_tol=1e-9)  # a power and its root, then a difference from 1
