"""The distance that the robots travel."""

import numpy as np

from fes.arithmetic import sums
from fes.arrays import geometry
from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from fes.extension.protocols import NoParameters
from world.metrics.tick_truth import TickTruth


class Travel:
    """The path lengths of the robots: sums of the distances between their positions at successive ticks."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
        self._lengths = np.zeros(context.robots)
        self._before: Floats | None = None

    def add(self, tick: TickTruth) -> None:
        """Add a tick."""
        poses = tick.state.poses
        if self._before is not None:
            x, y = (poses[:, :2] - self._before[:, :2]).T
            self._lengths = self._lengths + geometry.separation(x, y)
        self._before = poses

    def result(self) -> dict[str, float | None]:
        """The mean and the largest path length of a robot [m]."""
        return {"mean": sums.mean(self._lengths), "largest": float(self._lengths.max())}
