"""Ticks of a real robot: those of its wall clock at the start, counted on its monotonic clock from then on.

So robots whose wall clocks roughly agree, by NTP or GPS, have dithers in phase. A wall clock that jumps during the
run changes nothing.
"""


class TickClock:
    """The ticks of one robot."""

    def __init__(self, dt: float, wall: int, monotonic: int) -> None:
        """`dt` is the tick length [s]; `wall` and `monotonic` are both clocks at the start [ns]."""
        self.period = round(dt * 1e9)
        """Tick length [ns]."""
        self._offset = wall - monotonic

    def tick(self, now: int) -> int:
        """The tick that lasts at the time `now` [ns; monotonic].

        >>> TickClock(0.02, wall=1_000_000_000, monotonic=0).tick(39_999_999)
        51
        """
        return (now + self._offset) // self.period

    def start(self, tick: int) -> int:
        """Time at which a tick begins [ns; monotonic].

        >>> TickClock(0.02, wall=1_000_000_000, monotonic=0).start(51)
        20000000
        """
        return tick * self.period - self._offset
