"""The team index F: how well a team covers its area and delivers its messages, after the worst loss of one robot.

    ln F = lambda (mean over robots i of the sum over all j of ln c(r_ij)) - (mean cost of the best routes)

with J = c q of (16). c(r) = 1 - exp(-(r/r_min)^s) is its factor of coverage. The cost of a link is -ln q, and the
cost of a route is the sum over its links. The routes are those after the loss of that robot whose loss is worst,
unless `objective.losses` is 0. For two robots no loss is considered: with lambda = 1 their F is the J of their link.
`docs/explanation/team.md` says why.
"""

from typing import NamedTuple

import numpy as np

from fes.arithmetic import elementary, sums
from fes.arrays import geometry
from fes.arrays.types import Floats
from fes.model import objective
from fes.model.config import ObjectiveConfig
from world.metrics.team import delivery

MAX_ROBOTS = 100
"""Largest team whose index is computed. It takes 9 ms for 50 robots, and 40 ms for 100."""


class TeamIndex(NamedTuple):
    """The team index of one configuration, and its two factors."""

    value: float
    """F = coverage^lambda x delivery, in [0, 1]; 0 if two robots have no route, or stand at one place."""
    coverage: float
    """Geometric mean over the robots of the product of c to all others, in [0, 1]."""
    delivery: float
    """Geometric mean over pairs of the quality of their best route, after the worst loss, in [0, 1]."""


def team_index(positions: Floats, links: Floats, config: ObjectiveConfig) -> TeamIndex | None:
    """The team index of robots at `positions` [n, 2] [m], with the quality q of their `links` [n, n].

    None for fewer than two robots, and for more than MAX_ROBOTS.
    """
    if not 2 <= len(positions) <= MAX_ROBOTS:
        return None
    crowding, cost = _crowding(positions, config), delivery.route_cost(links, config.losses)
    exponents = np.array([config.coverage_weight * crowding - cost, crowding, -cost])
    return TeamIndex(*elementary.exp(exponents).tolist())


def _crowding(positions: Floats, config: ObjectiveConfig) -> float:
    """Mean over the robots of the sum of ln c over all others; -inf for two at one place."""
    first, second = np.triu_indices(len(positions), 1)
    x, y = (positions[first] - positions[second]).T
    with np.errstate(divide="ignore"):
        logs = elementary.log(objective.coverage(geometry.separation(x, y), config))
    return 2.0 * sums.total(logs) / len(positions)
