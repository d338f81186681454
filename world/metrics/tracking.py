"""How fast and how well the robots find the optimum: from the start, and after each change of the channel."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

NEAR = 1.0
"""The mean estimate is on the optimum while it is this near [m]."""

HOLD_AT_START, HOLD_AFTER_CHANGE = 10.0, 5.0
"""How long it must stay there to count [s]."""

SETTLED = 60.0
"""Errors are summed up from this time after the start or the change [s]."""

QUANTITIES = ("error", "disagreement", "separation", "index")


@dataclass(eq=False)
class Segment:
    """The time from the start, or from one change of the channel, to the next."""

    since: int
    """[ticks]"""
    optimal: float
    """r* [m]."""
    near_since: int | None = None
    """Tick from which the mean estimate has been near r*."""
    reached: int | None = None
    """The first such tick that was held."""
    sums: dict[str, float] = field(default_factory=lambda: dict.fromkeys(QUANTITIES, 0.0))
    squares: dict[str, float] = field(default_factory=lambda: dict.fromkeys(QUANTITIES, 0.0))
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(QUANTITIES, 0))
    disagreement: float = 0.0
    """Largest one [m]."""


class Tracking:
    """Follows the mean estimate; `add` is called at each tick."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self.segments: list[Segment] = []
        self.error = math.nan
        """Mean estimate less r* at the last tick [m]; NaN while there are no estimates."""

    @property
    def now(self) -> Segment:
        """The stretch that goes on."""
        return self.segments[-1]

    @property
    def time_to_near(self) -> float:
        """How long the robots took in this stretch [s]; NaN if they are not there yet."""
        reached = self.now.reached
        return math.nan if reached is None else (reached - self.now.since) * self._dt

    def settled(self, tick: int, changed: bool) -> bool:
        """Whether errors are being summed up at this tick, so that they need to be known."""
        return not changed and bool(self.segments) and tick - self.now.since >= SETTLED / self._dt

    def add(
        self,
        tick: int,
        optimal: float,
        changed: bool,
        error: float,
        disagreement: float,
        separation: float,
        index: float,
    ) -> None:
        """One more tick; what does not exist yet is NaN.

        `error` of the mean estimate [m]; `disagreement` over the links [m]; `separation`: rms over links of the
        separations' error, averaged over a dither period [m]; `index`: mean over links of the true J.
        """
        if changed or not self.segments:
            self.segments.append(Segment(tick, optimal))
        here, self.error = self.now, error
        hold = HOLD_AT_START if len(self.segments) == 1 else HOLD_AFTER_CHANGE
        if not abs(error) < NEAR:
            here.near_since = None
        elif here.near_since is None:
            here.near_since = tick
        if here.reached is None and here.near_since is not None and tick + 1 - here.near_since >= hold / self._dt:
            here.reached = here.near_since
        if self.settled(tick, False):
            for name, value in zip(QUANTITIES, (error, disagreement, separation, index), strict=True):
                if math.isfinite(value):
                    here.counts[name] += 1
                    here.sums[name] += value
                    here.squares[name] += value * value
            here.disagreement = float(np.fmax(here.disagreement, disagreement))

    def table(self) -> list[dict[str, Any]]:
        """For each stretch what the summary says of it; None where it was too short."""
        return [self._row(segment) for segment in self.segments]

    def _row(self, segment: Segment) -> dict[str, Any]:
        def mean(metrics: dict[str, float], name: str) -> float | None:
            return metrics[name] / segment.counts[name] if segment.counts[name] else None

        def root(name: str) -> float | None:
            square = mean(segment.squares, name)
            return None if square is None else math.sqrt(square)

        reached = segment.reached
        return {
            "at": round(segment.since * self._dt, 9),
            "optimal_separation": segment.optimal,
            "time_to_1m": None if reached is None else round((reached - segment.since) * self._dt, 9),
            "bias": mean(segment.sums, "error"),
            "rmse": root("error"),
            "separation_rmse": root("separation"),
            "disagreement_max": segment.disagreement if segment.counts["disagreement"] else None,
            "index": mean(segment.sums, "index"),
        }
