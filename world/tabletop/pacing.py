"""Steps that are due in real time, by a monotonic clock that is passed in."""

import math

LONGEST = 0.1
"""Longest delay that is made up for [s]. After a longer one the bodies have stood still for the rest of it: else they
would jump, driven by their last commands."""


class Pacing:
    """Deadlines at equal steps; a delay moves the later ones."""

    def __init__(self, step: float, now: float) -> None:
        self._step = step
        self._start = now
        self._done = 0
        self.lost = 0.0
        """Time for which the bodies have stood still because of delays [s]."""

    @property
    def next(self) -> float:
        """The next deadline [s; monotonic]."""
        return self._start + self.lost + (self._done + 1) * self._step

    def due(self, now: float) -> int:
        """Number of steps that are due now: all since the last call, of the last LONGEST seconds."""
        steps = math.floor((now - self.next) / self._step + 1e-9) + 1
        most = max(1, math.floor(LONGEST / self._step))
        if steps > most:
            self.lost += (steps - most) * self._step
            steps = most
        steps = max(0, steps)
        self._done += steps
        return steps
