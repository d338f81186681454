"""The pose of a robot at its ticks, from the poses that its body has reported at times of its own."""

import math
from collections import deque
from typing import NamedTuple

MEMORY = 256
"""Most poses that are remembered: those of one second at 250 Hz."""


Place = tuple[float, float, float]


class Pose(NamedTuple):
    """A pose that the body has reported."""

    time: int
    """Time of its arrival [ns; monotonic]."""
    pose: Place
    """x, y, heading [m, m, rad; team frame, full size]."""


class Fix(NamedTuple):
    """A pose for an Observation, and the tick at which it holds."""

    pose: Place
    tick: int


class Fixes:
    """The last poses of a body."""

    def __init__(self, period: int) -> None:
        """`period` is the tick length [ns]."""
        self._period = period
        self._poses = deque[Pose](maxlen=MEMORY)

    def add(self, pose: Pose) -> None:
        """Take a pose, at the time of its arrival."""
        self._poses.append(pose)

    @property
    def newest(self) -> Place | None:
        """The newest pose; None before the first."""
        return self._poses[-1].pose if self._poses else None

    def age(self, now: int) -> int | None:
        """Age of the newest pose [ns]; None before the first."""
        return now - self._poses[-1].time if self._poses else None

    def fix(self, tick: int, start: int, twist: tuple[float, float]) -> Fix | None:
        """The newest pose that had arrived when `tick` began at the time `start` [ns]; None without one.

        It is moved along `twist` [m/s, rad/s], the one in force, to the begin of a tick: of this one if it is younger
        than a tick, else of the tick that began nearest to its arrival. A pose arrives up to a tick before the step,
        in which a fast robot moves by centimeters.
        """
        shown = next((pose for pose in reversed(self._poses) if pose.time <= start), None)
        if shown is None:
            return None
        age = start - shown.time
        behind = 0 if age < self._period else round(age / self._period)
        ahead = 1e-9 * (start - behind * self._period - shown.time)
        return Fix(_moved(shown.pose, twist, ahead), tick - behind)


def _moved(pose: Place, twist: tuple[float, float], time: float) -> Place:
    """A pose after `twist` was held for `time` [s], on the arc of (5). No digit of a law depends on it."""
    if time == 0.0:
        return pose
    (x, y, heading), half = pose, 0.5 * time * twist[1]
    chord = time * twist[0] * (math.sin(half) / half if half else 1.0)
    middle = heading + half
    return x + chord * math.cos(middle), y + chord * math.sin(middle), math.remainder(middle + half, math.tau)
