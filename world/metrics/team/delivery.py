"""Delivery: the quality of the best route between two robots, averaged over the ordered pairs of the team.

The quality of a route is the product of the qualities q of its links. Let the cost of a link be w = -ln q. The best
route from i to j has the least sum of costs, delta(i, j), and the quality exp(-delta).

Links are a matrix [n, n]: the quality in [0, 1] from each sender (row) to each receiver (column). It is 0 where they
are out of range. The diagonal is not used.
"""

import math
from typing import NamedTuple

import numpy as np

from fes.arithmetic import elementary, sums
from fes.arrays import geometry
from fes.arrays.types import Floats, Ints
from fes.model.config import ObjectiveConfig
from fes.shapes.routes import between, relayed, without_each
from world.simulation.truth import State

MAX_ROBOTS = 300
"""Largest team whose delivery is computed. The work for losses grows as n^3 log n."""


class Delivery(NamedTuple):
    """Two means over the ordered pairs of robots, each in [0, 1]."""

    mean: float
    """Mean of exp(-delta); a pair without a route counts as 0."""
    geometric_mean: float
    """exp(-mean of delta): 0 if any pair has no route. For two robots with equal links it is their q."""


def link_quality(separation: Floats, reception: Floats, objective: ObjectiveConfig) -> Floats:
    """q = exp(-(r/r_x)^s) p, any shape: the factors of the index (16) that fall with the separation r [m].

    `reception` is p, the true probability that a beacon decodes on this link.
    """
    reach = elementary.power(separation / objective.maximum_separation, objective.shape_exponent)
    quality: Floats = elementary.exp(-reach) * reception
    return quality


def link_matrix(n: int, senders: Ints, receivers: Ints, quality: Floats) -> Floats:
    """The matrix [n, n] of the links from `senders` to `receivers`, both rows of robots [m], with `quality` [m]."""
    links = np.zeros((n, n))
    links[senders, receivers] = quality
    return links


def links_of(state: State, objective: ObjectiveConfig) -> Floats:
    """The quality of each link between the robots present [n, n]: 0 where they are out of range.

    p is the true reception probability of the last beacon of each contact, in its own direction: with shadowing,
    jammers and faults, and with the mean effect of bursts. A pair that came in range at this tick has none yet, and
    counts as out of range.
    """
    edges, poses = state.radio.edges, state.poses
    senders = np.searchsorted(edges.ids, edges.peers)
    x, y = (poses[senders, :2] - poses[edges.rows, :2]).T
    quality = link_quality(geometry.separation(x, y), np.nan_to_num(state.radio.probability), objective)
    rows, both = np.cumsum(state.present) - 1, state.present[senders] & state.present[edges.rows]
    ends = rows[senders[both]], rows[edges.rows[both]]
    return link_matrix(int(np.count_nonzero(state.present)), *ends, quality[both])


def delivery(links: Floats) -> Delivery | None:
    """Delivery between all robots of `links` [n, n]; None for fewer than 2 robots, or more than MAX_ROBOTS."""
    n = len(links)
    if not 2 <= n <= MAX_ROBOTS:
        return None
    return _average(relayed(_costs(links), range(n)), np.arange(n))


def delivery_after_loss(links: Floats) -> Delivery | None:
    """Delivery between the others after the loss of one robot: each mean after the loss that is worst for it.

    It is never above the delivery between all robots. In a team of two no loss is considered. None as for `delivery`.
    """
    n = len(links)
    if not 2 < n <= MAX_ROBOTS:
        return delivery(links)
    present = np.arange(n)
    losses = [_average(costs, np.delete(present, lost)) for lost, costs in without_each(_costs(links), range(n))]
    return Delivery(min(loss.mean for loss in losses), min(loss.geometric_mean for loss in losses))


def route_cost(links: Floats, losses: int) -> float:
    """The mean cost of the best routes between two of n >= 2 robots; infinite if two of them have no route.

    With `losses` = 1 it is the mean between the others after the loss that is worst. It is never below the mean
    without a loss, so that one does not count. In a team of two no loss is considered.
    """
    costs, n = _costs(links), len(links)
    if not losses or n == 2:
        return sums.mean(between(relayed(costs, range(n))))
    worst = -math.inf
    for lost, after in without_each(costs, range(n)):
        worst = max(worst, sums.mean(between(after, lost)))
        if worst == math.inf:
            break
    return worst


def _costs(links: Floats) -> Floats:
    """w = -ln q of each link [n, n]; infinite where there is no link."""
    with np.errstate(divide="ignore"):
        return -elementary.log(links)


def _average(costs: Floats, present: Ints) -> Delivery:
    """Delivery between the robots `present`, at the least `costs` [n, n] of routes."""
    n = len(present)
    between = costs[np.ix_(present, present)][~np.eye(n, dtype=bool)]
    geometric = elementary.exp(np.array([-sums.mean(between)]))
    return Delivery(sums.mean(elementary.exp(-between)), float(geometric[0]))
