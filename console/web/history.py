"""The history of a run for a page: the worst values over time, and the paths of the robots."""

import math

import numpy as np

from console.measures import team
from console.web.columns import Columns
from fes.arrays.types import Floats
from fes.protocol.report import Report

BINS = 1024
"""Number of bins of the curves. When they are full, pairs of bins are merged."""

PATH_LENGTH = 128
"""Largest number of points of a robot's path."""

PATH_POINTS = 8192
"""Largest number of points of all paths together, but for teams of more than a thousand robots."""

SERIES = ("first", "second", "third")
"""Columns of the measures that `console.measures.team.labels` names."""

MOST_CHANGES = 64
"""Largest number of changes of the channel that are marked."""


class History:
    """Bins of ticks of equal width, of one tick at first, and positions at some of the ticks."""

    def __init__(self) -> None:
        self.dt = 1.0
        """Tick length [s]."""
        self._scenario, self._robots = "", 0
        self._stride = self._pause = 1
        self._ticks: list[int] = []
        self._values: list[Floats] = []
        self._stops: list[int] = []
        """Ticks of the positions."""
        self._positions: list[Floats] = []
        self._changes: list[float] = []

    def add(self, report: Report) -> None:
        """Add a report. A world that resumes at an earlier tick replaces the ticks after it."""
        if report.scenario != self._scenario or len(report.poses) != self._robots:
            self.__init__()  # type: ignore[misc]
            self._scenario, self._robots = report.scenario, len(report.poses)
        elif self._ticks and report.tick <= self._ticks[-1]:
            self._forget_from(report.tick)
        self.dt = report.dt
        self._add_values(report)
        self._add_positions(report)
        if 0.0 < report.changed_at <= report.tick * report.dt:
            self._changes = sorted({*self._changes, report.changed_at})[-MOST_CHANGES:]

    def curves(self) -> Columns:
        """Time [s], the measures [m], and the team index and its target [1]; NaN where a log axis has no place."""
        values = np.array(self._values).reshape(len(self._values), len(SERIES) + 2)
        values[~(values > 0.0)] = math.nan
        measures = dict(zip((*SERIES, "index", "target"), values.T, strict=True))
        return {"time": np.array(self._ticks, dtype=np.float64) * self.dt, **measures}

    def changes(self) -> Columns:
        """Times at which the channel changed [s]."""
        return {"time": np.array(self._changes)}

    def paths(self, until: int) -> Columns:
        """Positions of all robots up to a tick [m], one robot after the other, with a gap of NaN between them."""
        positions = [place for tick, place in zip(self._stops, self._positions, strict=True) if tick <= until]
        gap = np.full((1, self._robots, 2), math.nan)
        path = np.concatenate([*(place[None] for place in positions), gap]).transpose(1, 0, 2).reshape(-1, 2)
        return {"x": path[:, 0].astype(np.float32), "y": path[:, 1].astype(np.float32)}

    def _add_values(self, report: Report) -> None:
        values = np.array([*team.series(report), report.team_index, report.team_index_target])
        if self._ticks and report.tick // self._stride == self._ticks[-1] // self._stride:
            self._values[-1] = _worst(self._values[-1], values)
            self._ticks[-1] = report.tick
            return
        self._ticks.append(report.tick)
        self._values.append(values)
        while len(self._ticks) > BINS:
            self._coarsen()

    def _coarsen(self) -> None:
        self._stride *= 2
        ticks, values = self._ticks, self._values
        self._ticks, self._values = [], []
        for tick, row in zip(ticks, values, strict=True):
            if self._ticks and tick // self._stride == self._ticks[-1] // self._stride:
                self._ticks[-1], self._values[-1] = tick, _worst(self._values[-1], row)
            else:
                self._ticks.append(tick)
                self._values.append(row)

    def _add_positions(self, report: Report) -> None:
        if self._stops and report.tick - self._stops[-1] < self._pause:
            return
        self._stops.append(report.tick)
        self._positions.append(np.where(team.on_map(report)[:, None], report.poses[:, :2], math.nan))
        if len(self._stops) > min(PATH_LENGTH, max(8, PATH_POINTS // max(1, self._robots))):
            self._stops, self._positions = self._stops[::2], self._positions[::2]
            self._pause = max(1, (self._stops[-1] - self._stops[0]) // max(1, len(self._stops) - 1))

    def _forget_from(self, tick: int) -> None:
        count = int(np.searchsorted(self._ticks, tick))
        self._ticks, self._values = self._ticks[:count], self._values[:count]
        count = int(np.searchsorted(self._stops, tick))
        self._stops, self._positions = self._stops[:count], self._positions[:count]
        self._changes = [time for time in self._changes if time <= tick * self.dt]


def _worst(first: Floats, second: Floats) -> Floats:
    """The larger errors, and the later team index and target."""
    errors = np.fmax(first[: len(SERIES)], second[: len(SERIES)])
    return np.concatenate([errors, second[len(SERIES) :]])
