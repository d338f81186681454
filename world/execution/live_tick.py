"""The rules of the live clock: the answer that each robot follows, silent robots, and the end of each tick.

A pure state machine, as `world.execution.barrier` is: commands and the time are arguments, and results are values.
"""

from enum import Enum, auto
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools, Ints
from world.execution.barrier import Participants
from world.metrics.deadlines import COMMAND_TIMEOUT

HANG_TIMEOUT = 2.0
"""A robot that sends no command for this long [s] is excluded, though its token may stay. When it sends one again, it
rejoins and starts without state."""


class Timing(Enum):
    """The order of a readable command among those of its robot, and its tick."""

    IN_TIME = auto()
    """The newest of its robot, for this tick."""
    LATE = auto()
    """The newest of its robot, for an earlier tick."""
    OLD = auto()
    """At most as new as the one that its robot follows."""
    FUTURE = auto()
    """For a tick that has not begun: an error."""


class End(NamedTuple):
    """The robots at the end of a tick."""

    following: Bools
    """Robots that follow their newest command; all others stop [n]."""
    silent: Bools
    """Robots that take part and sent no command for HANG_TIMEOUT [n]."""


class LiveTick:
    """The newest command of each robot, by its tick."""

    def __init__(self, robots: int, dt: float) -> None:
        self._dt = dt
        self._newest: Ints = np.full(robots, -1)
        """Tick of the newest command of each robot, -1 for none [n]."""

    def receive(self, command_tick: int, robot: int, tick: int) -> Timing:
        """A command of a robot has come, at the end of `tick`."""
        if command_tick > tick:
            return Timing.FUTURE
        if command_tick <= self._newest[robot]:
            return Timing.OLD
        self._newest[robot] = command_tick
        return Timing.LATE if command_tick < tick else Timing.IN_TIME

    def end(self, participants: Participants) -> End:
        """The robots at the end of a tick, with the commands until now."""
        tick, present, since = participants
        fresh = (self._newest >= since) & ((tick - self._newest) * self._dt < COMMAND_TIMEOUT)
        silent = (tick - np.maximum(self._newest, since)) * self._dt >= HANG_TIMEOUT
        return End(present & fresh, present & silent)


class LivePace:
    """The end of each tick on the wall clock. If the world itself is late, its clock slips: each tick has its full
    length, and none is skipped."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._due: float | None = None
        """End of the present tick [s]."""

    def rest(self, now: float) -> float:
        """The time that remains of the tick at `now` [s]."""
        self._due = (now if self._due is None else self._due) + self._dt
        return max(0.0, self._due - now)

    def slip(self, now: float) -> float:
        """The delay [s] by which the clock slips, if the tick ended at `now` [s] instead of when it was due."""
        behind = now - self._due if self._due is not None else 0.0
        if self._due is None or behind <= self._dt / 2.0:
            return 0.0
        self._due += behind
        return behind
