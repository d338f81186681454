"""Tracking of the optimum: time and accuracy, after the start and after each change of the channel."""

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

NEAR = 1.0
"""Largest distance of the mean estimate from r* that counts as reached [m]."""

HOLD_AT_START, HOLD_AFTER_CHANGE = 10.0, 5.0
"""Time for which the mean estimate must stay within NEAR [s]."""

SETTLED = 60.0
"""Errors are averaged from this time after the start or the change [s]."""


class TeamErrors(NamedTuple):
    """Errors over all links at one tick; NaN while an error is not defined."""

    error: float
    """Mean estimate minus r* [m]."""
    disagreement: float
    """Sum over the links of the difference of their two estimates [m]."""
    separation: float
    """Root mean square of the separations' errors, averaged over a dither period [m]."""
    performance_index: float
    """Mean over the links of the true index J [1]."""


def _zeros() -> dict[str, float]:
    return dict.fromkeys(TeamErrors._fields, 0.0)


@dataclass(eq=False)
class Segment:
    """The time from the start, or from one change of the channel, to the next change."""

    since: int
    """First tick of the segment."""
    optimal: float
    """r* [m]."""
    near_since: int | None = None
    """Tick from which the mean estimate has been near r*."""
    reached: int | None = None
    """First tick from which it stayed near for long enough."""
    totals: dict[str, float] = field(default_factory=_zeros)
    squares: dict[str, float] = field(default_factory=_zeros)
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(TeamErrors._fields, 0))
    disagreement: float = 0.0
    """Largest disagreement [m]."""


class Tracking:
    """Follows the mean estimate; call `add` once per tick."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self.segments: list[Segment] = []
        self.error = math.nan
        """Mean estimate minus r* at the last tick [m]; NaN while there are no estimates."""

    @property
    def now(self) -> Segment:
        """The current segment."""
        return self.segments[-1]

    @property
    def time_to_near(self) -> float:
        """Time from the start of the current segment until r* was reached [s]; NaN if it was not."""
        reached = self.now.reached
        return math.nan if reached is None else (reached - self.now.since) * self._dt

    def is_settled(self, tick: int, is_changed: bool) -> bool:
        """True if errors are averaged at this tick, so that they must be computed."""
        return not is_changed and bool(self.segments) and tick - self.now.since >= SETTLED / self._dt

    def add(self, tick: int, optimal: float, is_changed: bool, errors: TeamErrors) -> None:
        """Add a tick; a channel that `is_changed` begins a segment, in which r* is `optimal` [m]."""
        if is_changed or not self.segments:
            self.segments.append(Segment(tick, optimal))
        segment, self.error = self.now, errors.error
        hold = HOLD_AT_START if len(self.segments) == 1 else HOLD_AFTER_CHANGE
        if not abs(errors.error) < NEAR:
            segment.near_since = None
        elif segment.near_since is None:
            segment.near_since = tick
        near_since = segment.near_since
        if segment.reached is None and near_since is not None and tick + 1 - near_since >= hold / self._dt:
            segment.reached = near_since
        if self.is_settled(tick, False):
            for name, value in zip(TeamErrors._fields, errors, strict=True):
                if math.isfinite(value):
                    segment.counts[name] += 1
                    segment.totals[name] += value
                    segment.squares[name] += value * value
            segment.disagreement = float(np.fmax(segment.disagreement, errors.disagreement))

    def table(self) -> list[dict[str, Any]]:
        """The table `tracking` of a summary, one row per segment; a number that a short segment lacks is None."""
        return [self._row(segment) for segment in self.segments]

    def _row(self, segment: Segment) -> dict[str, Any]:
        def mean(totals: dict[str, float], name: str) -> float | None:
            return totals[name] / segment.counts[name] if segment.counts[name] else None

        def root(name: str) -> float | None:
            square = mean(segment.squares, name)
            return None if square is None else math.sqrt(square)

        reached = segment.reached
        return {
            "at": round(segment.since * self._dt, 9),
            "optimal_separation": segment.optimal,
            "time_to_1m": None if reached is None else round((reached - segment.since) * self._dt, 9),
            "bias": mean(segment.totals, "error"),
            "rmse": root("error"),
            "separation_rmse": root("separation"),
            "disagreement_max": segment.disagreement if segment.counts["disagreement"] else None,
            "index": mean(segment.totals, "performance_index"),
        }
