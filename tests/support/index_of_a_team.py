"""The team index by its definition, for a Rayleigh channel: a second program beside that of the world."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Floats
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.shapes import routes
from fes.shapes.choice import shape
from tests.support.configuration_starts import distances


class Index(NamedTuple):
    """F = exp(Phi) with one loss, for any number of robots."""

    objective: ObjectiveConfig = ObjectiveConfig()
    channel: ChannelConfig = ChannelConfig()

    def coverage(self, separation: Floats) -> Floats:
        """ln c."""
        return np.log(-np.expm1(-((separation / self.objective.minimum_separation) ** self.objective.shape_exponent)))

    def cost(self, separation: Floats) -> Floats:
        """w = -ln q; infinite out of range."""
        channel = self.channel
        threshold = (2.0**channel.spectral_efficiency - 1.0) / channel.reference_snr
        loss = threshold * (separation / channel.reference_distance) ** channel.path_loss_exponent
        reach = (separation / self.objective.maximum_separation) ** self.objective.shape_exponent
        return np.where(separation <= channel.communication_range, loss + reach, np.inf)

    def of(self, positions: Floats) -> float:
        """F of robots at `positions` [n, 2] [m]."""
        n, distance = len(positions), distances(positions)
        crowding = self.coverage(np.where(np.isinf(distance), 1e9, distance)).sum() / n
        cost = self.cost(distance)
        np.fill_diagonal(cost, 0.0)
        delays = [routes.between(routes.relayed(cost, range(n))).mean()]
        if n > 2:
            delays += [routes.between(c, lost).mean() for lost, c in routes.without_each(cost, range(n))]
        return float(np.exp(self.objective.coverage_weight * crowding - max(delays)))

    def best_spacing(self, quality_weight: float) -> float:
        """r_beta [m]: the separation that maximizes ln c + beta ln q, on a grid of 1 mm."""
        grid = np.arange(20.0, self.channel.communication_range, 1e-3)
        return float(grid[np.argmax(self.coverage(grid) - quality_weight * self.cost(grid))])


@lru_cache
def spacing(index: Index, n: int) -> float:
    """r_beta of the patch of `n` robots [m]."""
    return index.best_spacing(shape("lattice", n, 1).quality_weight(1, index.objective.coverage_weight))


@lru_cache
def target(index: Index, n: int) -> float:
    """F of the patch of `n` robots at r_beta."""
    return index.of(spacing(index, n) * shape("lattice", n, 1).slots)
