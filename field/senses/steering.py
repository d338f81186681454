"""Slow steering of a peer's offset: two clocks drift apart by up to 100 ppm, one tick of 20 ms in 200 s.

The slack of a beacon is the time [ticks] from its arrival until the step that needs it. A window of beacons gives its
low quantile, the slack of the least lucky ones. Between LEAST and MOST the offset stays. These are more than one tick
apart, so a change of one tick never leads to its reverse.

- Below LEAST the beacons come too late soon: they get slots one later.
- Above MOST they wait longer than they need: they get slots one earlier.

With LEAST = 0.25 the clocks have 5 ms to drift apart before a beacon comes too late, at 20 ms per tick. A full window
of 50 beacons lasts 1 s, in which they drift by 0.1 ms; without most of its beacons a window lasts 500 ticks, or 1 ms
of drift. The quantile excludes up to 3 of 50 beacons, which hiccups of a network or of a process may delay.
"""

import math

LEAST = 0.25
"""Low quantile of the slack below which the offset grows [ticks]."""

MOST = 1.5
"""Low quantile of the slack above which the offset shrinks [ticks]."""

BEACONS = 50
"""Beacons after which a window ends."""

TICKS = 500
"""Ticks after which a window ends with fewer beacons."""

OUTLIERS = 16
"""One of so many beacons is excluded as an outlier."""


class Steering:
    """The slacks of one window of a peer's beacons."""

    def __init__(self) -> None:
        self._slacks: list[float] = []
        self._began = 0.0

    def shift(self, slack: float, now: float) -> int:
        """The change of the offset [ticks], usually 0, after a beacon with this slack that arrived at `now`."""
        if not self._slacks:
            self._began = now
        self._slacks.append(slack)
        if len(self._slacks) < BEACONS and now - self._began < TICKS:
            return 0
        slacks, self._slacks = sorted(self._slacks), []
        low = slacks[len(slacks) // OUTLIERS]
        if low < LEAST:
            return max(1, _ticks(LEAST - slacks[-1]))  # more than one only if even the luckiest is late
        return -_ticks(low - MOST)


def _ticks(excess: float) -> int:
    """Whole ticks that remove an excess; 0 if it is none."""
    return max(0, math.ceil(excess))
