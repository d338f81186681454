"""Own poses of the last ticks, and the pose at any time between them. Pure."""

import math
from collections import deque

Pose = tuple[float, float, float]
"""x, y, heading [m, m, rad; team frame]."""

TICKS = 16
"""Own poses that are remembered."""


class OwnPoses:
    """The poses at the last own steps."""

    def __init__(self) -> None:
        self._poses: deque[tuple[int, Pose]] = deque(maxlen=TICKS)

    def add(self, tick: int, pose: Pose) -> None:
        """Remember the pose at the step of a tick; ticks ascend."""
        self._poses.append((tick, pose))

    def between(self, time: float) -> Pose:
        """The pose at a `time` [ticks], linear between two steps; the nearest one outside of them.

        Raises LookupError before the first step.
        """
        if not self._poses:
            raise LookupError("no own pose yet")
        after = self._poses[-1]
        for before in reversed(self._poses):
            if before[0] <= time:
                return before[1] if before[0] == after[0] else _between(before, after, time)
            after = before
        return after[1]


def _between(before: tuple[int, Pose], after: tuple[int, Pose], time: float) -> Pose:
    """The pose at `time` between two; the heading takes the shorter way."""
    share = (min(time, after[0]) - before[0]) / (after[0] - before[0])
    (x, y, heading), (next_x, next_y, next_heading) = before[1], after[1]
    turned = math.remainder(next_heading - heading, math.tau)
    return x + share * (next_x - x), y + share * (next_y - y), math.remainder(heading + share * turned, math.tau)
