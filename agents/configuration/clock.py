"""Periods on each robot's own clock. Period e begins at the robot's own tick e T."""

from typing import NamedTuple

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.extension.context import LawContext
from fes.model import counts


class Reading(NamedTuple):
    """The clocks of n robots at one tick."""

    epoch: Ints
    """Number of the period [n]."""
    time: Floats
    """Own time [n] [s]."""


class Clock:
    """The clocks of a crew."""

    def __init__(self, context: LawContext, period: float) -> None:
        self.ticks = counts.ticks_of(period, context.dt)
        """Length of a period [ticks]."""
        self.period = self.ticks * context.dt
        """Length of a period [s]."""
        self._context = context
        self._robots = Edges(context.ids, np.arange(len(context.ids)), context.ids)

    def read(self, tick: int) -> Reading:
        """The robots' clocks at a tick of the team. While a clock shows a time below 0, its period is 0."""
        skew, n = self._context.skew(tick, self._robots), len(self._context.ids)
        time = tick * self._context.dt + skew
        if len(skew) == 1:  # all clocks agree
            return Reading(np.full(n, self._epoch(tick, skew)[0]), np.full(n, time[0]))
        return Reading(self._epoch(tick, skew), time)

    def _epoch(self, tick: int, skew: Floats) -> Ints:
        shift = counts.nearest(skew, self._context.dt)
        epoch: Ints = np.maximum(tick + shift, 0) // self.ticks
        return epoch
