"""A shape: where robots stand around their mean in units of the link length, and which pairs are links."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fes.arithmetic import sums
from fes.arrays import geometry
from fes.arrays.types import Bools, Floats
from fes.shapes import routes

TOLERANCE = 0.1
"""Two robots are linked if they are at most this share further apart than the nearest two. In a lattice, a ring and a
ladder these are the pairs at unit distance: the next ones are 1.4 times as far."""


@dataclass(frozen=True, eq=False)
class Shape:
    """The shape of a team of n robots."""

    slots: Floats
    """Places around their mean [n, 2] [link lengths]."""
    is_link: Bools
    """True for two robots that are linked [n, n]."""

    @property
    def links(self) -> int:
        """Number of links."""
        return int(np.count_nonzero(self.is_link)) // 2

    @property
    def neighbors(self) -> float:
        """k: mean number of neighbors of a robot."""
        return float(np.count_nonzero(self.is_link)) / len(self.slots)

    @property
    def reach(self) -> float:
        """Distance of the outermost robot from the mean [link lengths]."""
        return float(geometry.separation(self.slots[:, 0], self.slots[:, 1]).max())

    def hops(self, losses: int) -> float:
        """h: mean number of hops between two robots, after the loss that is worst, if `losses` is 1.

        A loss that leaves robots without a route does not count. Two robots are spared the loss. 0 for one robot.
        """
        return self._hops[1 if losses else 0]

    @cached_property
    def _hops(self) -> tuple[float, float]:
        n = len(self.slots)
        if n < 2:
            return 0.0, 0.0
        steps = np.where(self.is_link, 1.0, np.inf)
        steps[np.diag_indices(n)] = 0.0
        before = sums.mean(routes.between(routes.relayed(steps, range(n))))
        if n == 2:
            return before, before
        after = [sums.mean(routes.between(costs, lost)) for lost, costs in routes.without_each(steps, range(n))]
        return before, max([before, *(mean for mean in after if mean < np.inf)])

    def quality_weight(self, losses: int, coverage_weight: float) -> float:
        """beta = h / (lambda k): weight of a link's ln q against its ln c.

        The link length that maximizes ln c + beta ln q has the best team index, to first order, where no loss leaves
        a gap in the shape. It is 1 / lambda for one or two robots: with lambda = 1 the team index is then (16).
        """
        if len(self.slots) < 3:
            return 1.0 / coverage_weight
        return self.hops(losses) / (coverage_weight * self.neighbors)


def of_slots(places: Floats) -> Shape:
    """The shape with robots at `places` [n, 2] [link lengths], moved so that their mean is 0."""
    n = len(places)
    slots = places - sums.of_columns(places) / n
    return Shape(slots, links_of(slots))


def links_of(slots: Floats) -> Bools:
    """True for each two of the robots at `slots` [n, 2] that are linked [n, n]."""
    distance = geometry.distances(slots)
    distance[np.diag_indices(len(slots))] = np.inf
    linked: Bools = distance <= (1.0 + TOLERANCE) * distance.min()
    return linked if len(slots) > 1 else np.zeros((1, 1), dtype=np.bool_)
