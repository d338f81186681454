"""Metrics of the configuration at the last tick: they keep that tick, and compute when the summary asks."""

import numpy as np

from fes.extension.context import WorldContext
from fes.extension.protocols import NoParameters
from fes.model.table import Positive, Table
from world.metrics.team import coverage
from world.metrics.team import delivery as deliveries
from world.metrics.team.progress import cutting_number, index_of
from world.metrics.tick_truth import TickTruth
from world.simulation.truth import State


class CoveredAreaParameters(Table):
    """The parameters of the metric `covered_area`."""

    radius: Positive | None = None
    """Radius that each robot covers [m]; by default the smallest separation that the team prefers (r_min)."""


class CoveredArea:
    """The area that the robots present cover together."""

    Parameters = CoveredAreaParameters

    def __init__(self, parameters: CoveredAreaParameters, context: WorldContext) -> None:
        self._radius = parameters.radius or context.objective.minimum_separation
        self._last: State | None = None

    def add(self, tick: TickTruth) -> None:
        """Keep the tick."""
        self._last = tick.state

    def result(self) -> dict[str, float | None]:
        """The area [m^2], and its share of the area of as many discs that lie apart [1]."""
        if self._last is None or not self._last.present.any():
            return {"area": None, "share": None}
        positions = self._last.poses[self._last.present, :2]
        area = coverage.covered_area(positions, self._radius)
        return {"area": area, "share": area / (len(positions) * np.pi * (self._radius * self._radius))}


class TeamDelivery:
    """Delivery between the robots present over their best routes, and after the worst loss of one robot."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
        self._objective = context.objective
        self._last: State | None = None

    def add(self, tick: TickTruth) -> None:
        """Keep the tick."""
        self._last = tick.state

    def result(self) -> dict[str, float | None]:
        """The arithmetic and the geometric mean over pairs [1], for all robots and after the worst loss.

        None for fewer than two robots, and for more than `delivery.MAX_ROBOTS`.
        """
        is_small = self._last is not None and np.count_nonzero(self._last.present) <= deliveries.MAX_ROBOTS
        links = deliveries.links_of(self._last, self._objective) if self._last and is_small else np.zeros((0, 0))
        now, after = deliveries.delivery(links), deliveries.delivery_after_loss(links)
        return {
            "mean": now and now.mean,
            "geometric_mean": now and now.geometric_mean,
            "mean_after_loss": after and after.mean,
            "geometric_mean_after_loss": after and after.geometric_mean,
        }


class TeamIndexAtTheEnd:
    """The team index of the robots present, and how many of them cut the links."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
        self._objective = context.objective
        self._last: TickTruth | None = None

    def add(self, tick: TickTruth) -> None:
        """Keep the tick."""
        self._last = tick

    def result(self) -> dict[str, float | None]:
        """F [1], and the number of robots whose loss would cut the links in use between the others.

        F is None for fewer than two robots, and for more than `team_index.MAX_ROBOTS`; the number is None if the
        links do not connect the robots present.
        """
        if self._last is None:
            return {"value": None, "cutting_robots": None}
        state = self._last.state
        index = index_of(state, self._objective)
        cutting = cutting_number(state, self._last.telemetry)
        return {"value": index and index.value, "cutting_robots": None if cutting is None else float(cutting)}
