"""The index J of (16), averaged over the robots' links: its value at the end, and the time when it settled."""

import math

import numpy as np

from fes.arithmetic import sums
from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from fes.model import objective
from fes.model.table import NonNegative, Positive, Table
from world.metrics.collector import link_reception
from world.metrics.tick_truth import TickTruth

MOST_SAMPLES = 2**15
"""Largest number of samples: at 50 Hz every tick of 655 s. In a longer run every second one is kept, and so on."""


class LinkIndexParameters(Table):
    """The parameters of the metric `link_index`."""

    window: NonNegative = 20.0
    """Time at the end of the run over which J is averaged [s]: a whole number of periods of a physical dither."""
    tolerance: Positive = 0.01
    """Largest deviation from that mean that counts as settled, as a share of the mean [1]."""


class LinkIndex:
    """The mean over the robots' links of the true J. A link whose robots are out of range has J = 0."""

    Parameters = LinkIndexParameters

    def __init__(self, parameters: LinkIndexParameters, context: WorldContext) -> None:
        self._parameters, self._context = parameters, context
        self._samples: list[float] = []
        self._every = 1
        self._links = 0

    def add(self, tick: TickTruth) -> None:
        """Add a tick."""
        self._links = len(tick.separation)
        if tick.state.tick % self._every:
            return
        self._samples.append(_mean_index(tick, self._context))
        if len(self._samples) >= MOST_SAMPLES:
            self._samples, self._every = self._samples[::2], 2 * self._every

    def result(self) -> dict[str, float | None]:
        """The mean over the window at the end [1], the time from which J stays close to it [s], and the links.

        Without a link J is 0. The time is None if J leaves the tolerance within the window.
        """
        if not self._samples:
            return {"mean": None, "settled_at": None, "links": None}
        values, step = np.array(self._samples), self._context.dt * self._every
        window = max(1, math.ceil(self._parameters.window / step - 1e-9))
        mean = sums.mean(values[-window:])
        outside = np.flatnonzero(np.abs(values - mean) > self._parameters.tolerance * mean)
        first = int(outside[-1]) + 1 if len(outside) else 0
        is_settled = first == 0 or first <= len(values) - window
        return {"mean": mean, "settled_at": first * step if is_settled else None, "links": float(self._links)}


def _mean_index(tick: TickTruth, context: WorldContext) -> float:
    """The mean of J over the links of a tick; 0 without a link."""
    if not len(tick.separation):
        return 0.0
    reception: Floats = np.nan_to_num(link_reception(tick.state.radio, tick.telemetry.links))
    return sums.mean(objective.preference(tick.separation, context.objective) * reception)
