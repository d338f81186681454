"""The reports so far: the latest one, the worst errors over time, the paths of the robots, the extent of the team."""

import numpy as np

from console.measures.team import SERIES, on_map, series
from fes.arrays.types import Bools, Floats, Ints
from fes.protocol.report import Report

CAPACITY = 1024
"""Number of bins of a history."""

PLACES = 128
"""Largest number of places of a path."""

MOST_PATHS = 256
"""Largest number of robots whose paths are kept."""

_SLACK = 0.15  # share by which the team's extent changes before the panels move


class ReportHistory:
    """The latest Report, and the worst values of each bin of ticks of the run so far.

    A bin is one tick wide at first. When all bins are full, pairs of bins are merged.
    """

    def __init__(self) -> None:
        self.latest: Report | None = None
        self.silence = 0.0
        """Time since the last sign of life of a running run [s; wall clock]."""
        self.modes = ""
        """The modes of the gates of real robots, in words."""
        self.expected = "the world"
        """The program or the robots whose first report is awaited."""
        self.source = ""
        """Source of the index in words, such as `oracle`; empty if it is not known."""
        self.extent: Floats = np.zeros(2)
        """Width and height of the team [m], within _SLACK."""
        self._clear()

    def add(self, report: Report) -> None:
        """Add a Report; a tick before the latest starts a new run."""
        if self.latest and (report.tick < self.latest.tick or report.scenario != self.latest.scenario):
            self._clear()
        self.latest = report
        while report.tick // self.stride >= CAPACITY:
            self._coarsen()
        index = report.tick // self.stride
        values = series(report)
        self._worst[:, index] = np.fmax(self._worst[:, index], np.where(np.isfinite(values), values, np.nan))
        self._seen[index] = True
        changed = report.changed_at / report.dt if report.dt > 0.0 else 0.0
        if 0.0 < changed <= report.tick:
            self._changed[round(changed) // self.stride] = True
        self._paths.add(report)
        self._measure(report)

    @property
    def ticks(self) -> tuple[int, int]:
        """First and last tick of the series."""
        return int(self._seen.argmax()) * self.stride, self.latest.tick if self.latest else 0

    @property
    def paths(self) -> Floats:
        """Places of each robot, oldest first [t, n, 2] [m]; [0, 0, 2] for more robots than MOST_PATHS."""
        return self._paths.places

    def series(self, columns: int) -> Floats:
        """Worst value in each of `columns` equal parts of the run so far [3, columns] [m]; rows: SERIES."""
        seen = np.flatnonzero(self._seen)
        if len(seen) == 0:
            return np.full((len(SERIES), columns), np.nan)
        column = (seen - seen[0]) * columns // (seen[-1] - seen[0] + 1)
        filled, first = np.unique(column, return_index=True)
        worst = np.fmax.reduceat(self._worst[:, seen], first, axis=1)
        # A part without a report repeats the part before it
        held: Floats = worst[:, np.searchsorted(filled, np.arange(columns), side="right") - 1]
        return held

    def changes(self, columns: int) -> Ints:
        """Indices of those of `columns` equal parts of the run so far in which the channel changed [k]."""
        seen, changed = np.flatnonzero(self._seen), np.flatnonzero(self._changed)
        if len(seen) == 0:
            return changed
        inside = changed[(changed > seen[0]) & (changed <= seen[-1])]
        return np.unique((inside - seen[0]) * columns // (seen[-1] - seen[0] + 1))

    def _measure(self, report: Report) -> None:
        """Follow the extent of the team in steps, so that the panels do not move with every tick."""
        positions = report.poses[on_map(report), :2]
        extent = np.ptp(positions, axis=0) if len(positions) else np.zeros(2)
        if np.any(np.abs(extent - self.extent) > _SLACK * np.maximum(extent, self.extent)):
            self.extent = extent

    def _clear(self) -> None:
        self.stride = 1
        """Ticks per bin."""
        self.extent = np.zeros(2)
        self._paths = _Paths()
        self._empty()

    def _empty(self) -> None:
        self._worst: Floats = np.full((len(SERIES), CAPACITY), np.nan)
        self._seen: Bools = np.zeros(CAPACITY, dtype=np.bool_)
        self._changed: Bools = np.zeros(CAPACITY, dtype=np.bool_)

    def _coarsen(self) -> None:
        half = CAPACITY // 2
        worst, seen, changed = self._worst, self._seen, self._changed
        self.stride *= 2
        self._empty()
        self._worst[:, :half] = np.fmax(worst[:, 0::2], worst[:, 1::2])
        self._seen[:half] = seen[0::2] | seen[1::2]
        self._changed[:half] = changed[0::2] | changed[1::2]


class _Paths:
    """Positions of all robots at equal steps of the run; the steps double when PLACES are full."""

    def __init__(self) -> None:
        self._stride = 1
        self._samples: list[tuple[int, Floats]] = []

    @property
    def places(self) -> Floats:
        """The positions [t, n, 2] [m]."""
        return np.array([positions for _, positions in self._samples]) if self._samples else np.zeros((0, 0, 2))

    def add(self, report: Report) -> None:
        """Add the positions of a Report, unless its step of the run has some."""
        if len(report.poses) > MOST_PATHS or (self._samples and report.tick // self._stride <= self._last):
            return
        if self._samples and len(self._samples[0][1]) != len(report.poses):
            self._samples.clear()
        self._samples.append((report.tick, report.poses[:, :2].copy()))
        if len(self._samples) > PLACES:
            self._stride *= 2
            steps = [tick // self._stride for tick, _ in self._samples]
            self._samples = [place for k, place in enumerate(self._samples) if k == 0 or steps[k] != steps[k - 1]]

    @property
    def _last(self) -> int:
        """The last step that has positions."""
        return self._samples[-1][0] // self._stride
