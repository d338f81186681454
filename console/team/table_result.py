"""The result of a team on a table: the robots' reports beside the truth of the bodies.

Separations are averaged over the last period of the dither, as in the summary of a simulated run: with a physical
dither a formation oscillates.
"""

import bisect
import math
from collections import deque
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fes.arrays.types import Floats, Ints
from fes.errors import FesError, reason
from fes.protocol.report import Report
from fes.system import files, strict_json

LARGEST = 1 << 28
"""Largest file of the truth [bytes]: one of ten robots and two days."""

CLOSE = 1.0
"""Error below which an estimate or a separation counts as reached [m]."""


class Moment(NamedTuple):
    """The reports of the robots at one time."""

    time: float
    """Monotonic time [s]."""
    a: Ints
    b: Ints
    """Links [l]."""
    estimates: Floats
    """Both ends' estimates [2, l] [m]."""


class Truth(NamedTuple):
    """The bodies over time."""

    times: list[float]
    """Monotonic times [s], ascending."""
    positions: Floats
    """True positions at full size [t, n, 2] [m]."""
    bodies: list[float]
    """Time of the bodies at each of them [s]: they stand still while their process gets no processor."""

    def lost(self, begin: float) -> float:
        """Time for which the bodies stood still since the monotonic time `begin` [s]."""
        first = min(bisect.bisect_left(self.times, begin), len(self.times) - 1)
        return self.times[-1] - self.times[first] - (self.bodies[-1] - self.bodies[first])

    def positions_at(self, time: float) -> Floats:
        """The positions at a time [n, 2], linear between two lines of the file."""
        place = min(max(bisect.bisect_right(self.times, time), 1), len(self.times) - 1)
        before, after = self.times[place - 1], self.times[place]
        share = min(max((time - before) / max(after - before, 1e-9), 0.0), 1.0)
        result: Floats = (1.0 - share) * self.positions[place - 1] + share * self.positions[place]
        return result


class TableResult:
    """Collects the reports of a run."""

    def __init__(self, optimum: float, period: float | None) -> None:
        """`optimum` is r* [m], `period` that of a physical dither [s]; None without one."""
        self._optimum, self._period = optimum, period or 0.0
        self._moments: list[Moment] = []

    def add(self, report: Report, time: float) -> None:
        """Add the merged report at a monotonic time [s]."""
        self._moments.append(Moment(time, report.a, report.b, np.array([report.estimate_ab, report.estimate_ba])))

    def summary(self, started: float, truth: Truth) -> dict[str, Any]:
        """The numbers of the run; times count from `started` [s; monotonic]. None for a number that is not known."""
        moments = [moment for moment in self._moments if moment.time >= started and len(moment.a)]
        times = [moment.time - started for moment in moments]
        estimates = [float(np.nanmean(moment.estimates)) - self._optimum for moment in moments]
        separations = _Averages(self._period)
        means = [separations.add(moment, truth.positions_at(moment.time)) for moment in moments]
        worst = [float(np.abs(mean - self._optimum).max()) if len(mean) else math.nan for mean in means]
        last = means[-1] - self._optimum if means else np.zeros(0)
        table = {
            "optimal_separation": self._optimum,
            "moved_s": times[-1] if times else 0.0,
            "mean_estimate_error": estimates[-1] if estimates else math.nan,
            "estimate_time": _since(times, estimates),
            "links": len(last),
            "separation_error_max": float(np.abs(last).max()) if len(last) else math.nan,
            "separation_error_rms": float(np.sqrt(np.mean(last * last))) if len(last) else math.nan,
            "separation_time": _since(times, worst),
            "bodies_lost_s": max(0.0, truth.lost(started)),
        }
        finite: dict[str, Any] = strict_json.finite(table)
        return finite


class _Averages:
    """Separations of the links, averaged over the last period; a link that is younger has none."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._past: dict[tuple[int, int], deque[tuple[float, float]]] = {}

    def add(self, moment: Moment, positions: Floats) -> Floats:
        """The averages of the links of a moment, for `positions` [n, 2]; only those with a full period."""
        pairs = list(zip(moment.a.tolist(), moment.b.tolist(), strict=True))
        self._past = {pair: self._past.get(pair, deque()) for pair in pairs}
        means = []
        for (a, b), past in self._past.items():
            past.append((moment.time, float(np.hypot(*(positions[a] - positions[b])))))
            while len(past) > 1 and moment.time - past[1][0] >= self._period:  # reports come at irregular times
                past.popleft()
            if moment.time - past[0][0] >= self._period:
                means.append(sum(separation for _, separation in past) / len(past))
        return np.array(means)


def _since(times: list[float], errors: list[float]) -> float:
    """First time from which on every error is below CLOSE [s]; NaN if the last one is not, or is not known."""
    first = math.nan
    for time, error in zip(reversed(times), reversed(errors), strict=True):
        if not abs(error) < CLOSE:
            break
        first = time
    return first


def read_truth(path: Path) -> Truth:
    """The truth in the file of fes-tabletop; raises FesError if it cannot be used. A line that was cut ends it."""
    try:
        lines = files.read(path, LARGEST).splitlines()
    except OSError as error:
        raise FesError(f"{path} cannot be read: {reason(error, with_file=False)}") from None
    times, bodies, positions = list[float](), list[float](), list[list[list[float]]]()
    for line in lines:
        try:
            values = strict_json.loads(line)
        except ValueError:
            break
        times.append(float(values["monotonic"]))
        bodies.append(float(values["time"]))
        positions.append(values["poses"])
    if len(times) < 2:
        raise FesError(f"{path} has fewer than two lines of true poses")
    return Truth(times, np.array(positions)[:, :, :2], bodies)
