"""The participation of a real robot in its team: its begin, its end, and a new begin.

A robot that is stopped, or does not know where it is, sends no beacon. Its peers then soon forget it. When it returns
it starts anew: it cannot know which beacons were sent while it did not listen, so it must not count them as lost.
"""

from fes.protocol.robot_control import STOPPED

LONGEST_GAP = 1_000_000_000
"""A robot that was without a pose, or suspended, for longer than this starts anew [ns]."""


class Participation:
    """The state of one robot's participation."""

    def __init__(self) -> None:
        self.since: int | None = None
        """Tick from which the robot takes part; None while it does not."""
        self._last = 0

    def step(self, tick: int, start: int, mode: str, pose_age: int | None) -> int | None:
        """The tick from which the robot takes part, if it does at `tick`; else None.

        `start` is the begin of the tick [ns; monotonic], `mode` that of the gate, `pose_age` the age of the newest
        pose [ns], None before the first.
        """
        knows = pose_age is not None and pose_age <= LONGEST_GAP
        if mode in ("", STOPPED) or not knows:
            self.since = None
            return None
        if self.since is None or start - self._last > LONGEST_GAP:
            self.since = tick
        self._last = start
        return self.since
