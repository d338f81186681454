"""Delivery against an independent program, hand numbers, and scipy's search without each robot."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import csgraph_from_dense, dijkstra

from fes.arrays.types import Floats
from fes.model import objective
from fes.model.outage import reception_probability
from tests.support.configurations import BEST, CHANNEL, OBJECTIVE, STUDIED
from world.metrics.team.delivery import (
    MAX_ROBOTS,
    Delivery,
    delivery,
    delivery_after_loss,
    link_matrix,
    link_quality,
)

ROUNDING = 1e-12
"""Relative error of a few hundred roundings."""


def links_between(positions: Floats) -> Floats:
    """The links of robots within communication range of each other, over the paper's channel."""
    separation = np.hypot(*(positions[:, None] - positions).T)
    senders, receivers = np.nonzero((separation > 0.0) & (separation <= CHANNEL.communication_range))
    near = separation[senders, receivers]
    quality = link_quality(near, reception_probability(near, CHANNEL), OBJECTIVE)
    return link_matrix(len(positions), senders, receivers, quality)


def by_search(links: Floats) -> Delivery:
    """Delivery by scipy's Dijkstra."""
    with np.errstate(divide="ignore"):
        costs = dijkstra(csgraph_from_dense(-np.log(links), null_value=np.inf))
    between = costs[~np.eye(len(links), dtype=bool)]
    return Delivery(float(np.mean(np.exp(-between))), math.exp(-float(np.mean(between))))


@st.composite
def teams(draw: st.DrawFn) -> Floats:
    """Links of 3 to 9 robots, some missing, and different in the two directions."""
    n = draw(st.integers(3, 9))
    qualities = st.just(0.0) | st.floats(1e-6, 0.999)
    return np.array(draw(st.lists(qualities, min_size=n * n, max_size=n * n))).reshape(n, n)


@pytest.mark.parametrize("name", STUDIED)
def test_the_studied_configurations_have_their_known_delivery(name: str) -> None:
    expected = STUDIED[name]
    links = links_between(expected.positions)
    intact, after_loss = delivery(links), delivery_after_loss(links)
    assert intact is not None
    assert after_loss is not None
    assert intact.geometric_mean == pytest.approx(expected.delivery, abs=0.0005)
    assert after_loss.geometric_mean == pytest.approx(expected.after_loss, abs=0.0005)


def test_the_middle_robot_relays_unless_the_direct_link_is_better() -> None:
    links = np.array([[0.0, 0.5, 0.1], [0.5, 0.0, 0.5], [0.1, 0.5, 0.0]])
    assert delivery(links) == pytest.approx(((0.5 + 0.5 + 0.25) / 3.0, (0.5 * 0.5 * 0.25) ** (1.0 / 3.0)))
    assert delivery_after_loss(links) == pytest.approx((0.1, 0.1))  # without the middle robot
    links[0, 2] = links[2, 0] = 0.3
    assert delivery(links) == pytest.approx(((0.5 + 0.5 + 0.3) / 3.0, (0.5 * 0.5 * 0.3) ** (1.0 / 3.0)))


def test_a_pair_without_a_route_delivers_nothing() -> None:
    links = link_matrix(3, np.array([0, 1, 1, 2]), np.array([1, 0, 2, 1]), np.array([0.5, 0.5, 0.5, 0.5]))
    assert delivery_after_loss(links) == (0.0, 0.0)
    links[1, 2] = links[2, 1] = 0.0
    assert delivery(links) == pytest.approx((2 * 0.5 / 6, 0.0))


def test_a_link_may_have_one_direction_only() -> None:
    links = link_matrix(3, np.array([0, 1, 2]), np.array([1, 2, 0]), np.array([0.5, 0.5, 0.5]))
    assert links.tolist() == [[0.0, 0.5, 0.0], [0.0, 0.0, 0.5], [0.5, 0.0, 0.0]]
    assert delivery(links) == pytest.approx(((3 * 0.5 + 3 * 0.25) / 6, math.sqrt(0.5 * 0.25)))


@given(teams())
def test_delivery_is_that_of_scipys_search_without_each_robot(links: Floats) -> None:
    assert delivery(links) == pytest.approx(by_search(links), rel=1e-9)
    losses = [by_search(np.delete(np.delete(links, lost, 0), lost, 1)) for lost in range(len(links))]
    worst = tuple(min(values) for values in zip(*losses, strict=True))
    assert delivery_after_loss(links) == pytest.approx(worst, rel=1e-9)


def test_delivery_of_a_hundred_robots_is_that_of_scipys_search_without_each_robot() -> None:
    links = links_between(np.random.default_rng(6).uniform(0.0, 500.0, (100, 2)))
    losses = [by_search(np.delete(np.delete(links, lost, 0), lost, 1)) for lost in range(100)]
    worst = tuple(min(values) for values in zip(*losses, strict=True))
    assert worst[1] > 0.0
    assert delivery_after_loss(links) == pytest.approx(worst, rel=ROUNDING)


@given(teams())
def test_a_loss_never_improves_delivery(links: Floats) -> None:
    intact, after_loss = delivery(links), delivery_after_loss(links)
    assert intact is not None
    assert after_loss is not None
    assert after_loss.mean <= intact.mean * (1.0 + ROUNDING)
    assert after_loss.geometric_mean <= intact.geometric_mean * (1.0 + 1e-9)  # the exponent is at most a few hundred


def test_two_robots_deliver_by_their_link_and_no_loss_is_considered() -> None:
    links = links_between(np.array([(0.0, 0.0), (BEST, 0.0)]))
    assert delivery(links) == pytest.approx((links[0, 1], links[0, 1]), rel=ROUNDING)
    assert delivery_after_loss(links) == delivery(links)


def test_teams_of_one_robot_or_too_many_have_no_delivery() -> None:
    for n in (0, 1, MAX_ROBOTS + 1):
        assert delivery(np.ones((n, n))) is None
        assert delivery_after_loss(np.ones((n, n))) is None
    assert delivery(np.ones((MAX_ROBOTS, MAX_ROBOTS))) == (1.0, 1.0)


def test_the_geometric_mean_of_routes_too_poor_for_a_float_is_exact() -> None:
    n, quality = MAX_ROBOTS, 0.01
    first = np.arange(n - 1)
    chain = link_matrix(n, first, first + 1, np.full(n - 1, quality))
    result = delivery(chain + chain.T)
    assert quality ** (n - 1) == 0.0
    assert result is not None
    # the mean distance on a chain of n is (n + 1)/3 links
    assert result.geometric_mean == pytest.approx(quality ** ((n + 1) / 3.0), rel=1e-9)


def test_the_index_of_a_link_is_its_coverage_factor_times_its_quality() -> None:
    separation = np.linspace(1.0, 150.0, 50)
    reception = reception_probability(separation, CHANNEL)
    covered = -np.expm1(-((separation / OBJECTIVE.minimum_separation) ** OBJECTIVE.shape_exponent))
    index = objective.preference(separation, OBJECTIVE) * reception
    assert covered * link_quality(separation, reception, OBJECTIVE) == pytest.approx(index, rel=ROUNDING)
