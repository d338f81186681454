"""The life cycle of each robot in a run: from the lease of a robot to the ticks in which it takes part.

A pure state machine: events and the time are arguments, and results are values. It reads no clock, waits for nothing
and logs nothing. Robots of one process join and leave together, as the Join of their agent names them.

    event           effect on the robot and, except for a lease or a fault, on all robots of its process
    lease, join     promised for LEASE to the agent that asks, and to no other (`hosting`)
    token           alive; a token that is lost in a running run costs the tick, because messages are lost
    silent          hung until its next message, or until its token is lost
    exclude         takes no part until another agent joins for it (`hosting`)
    begin_tick      takes part if it is alive, neither hung nor at fault, and not absent by schedule
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools
from fes.protocol.messages import Join
from world.config import events
from world.config.events import ParticipationChange
from world.execution.hosting import NEVER, Hosting, Membership


class Facts(NamedTuple):
    """The state of one robot; times are those of the events [s]."""

    is_alive: bool
    host: Join | None
    """The last Join that was accepted for it."""
    is_hosted: bool
    is_renewed: bool
    """True if its agent is new, and has not taken part yet."""
    promised_until: float
    leased_until: float
    fault: str
    """Reason why it is excluded; empty if it is not."""
    is_hung: bool
    is_suspended: bool
    is_disconnected: bool


class Lifecycle:
    """The life cycles of all robots of a run."""

    def __init__(
        self, robots: int, schedule: Mapping[int, ParticipationChange], members: Membership, now: float
    ) -> None:
        """`schedule` maps ticks to changes of participation, in order."""
        self.hosting = Hosting(robots, members, now)
        """The agents of the robots."""
        self.robots, self._schedule = robots, schedule
        self.is_running = False
        """True after `begin_run`."""
        self._hung: Bools = np.zeros(robots, dtype=np.bool_)
        """Robots that did not answer in time, and all robots of the same process [n]."""
        self._suspended: Bools = self._hung.copy()
        """Robots that hang by schedule at this tick, each in a process of its own [n]."""
        self._disconnected: Bools = self._hung.copy()
        """Robots whose token was lost since the last tick [n]. It may have a new
        token, but messages sent in between are lost."""

    @property
    def reachable(self) -> Bools:
        """Robots that can answer, as can all robots of the same process [n].

        Excludes processes suspended by schedule, whose queues must stay empty. In a multi-robot process the scheduled
        robot keeps receiving, because its process keeps running.
        """
        return self._answering & ~self._suspended & ~self._disconnected

    def facts(self, robot: int) -> Facts:
        """The state of a robot."""
        hosting = self.hosting
        return Facts(
            bool(hosting.alive[robot]),
            hosting.hosts.get(robot),
            bool(hosting.hosted[robot]),
            robot in hosting.renewed,
            hosting.promised.get(robot, NEVER),
            hosting.leased.get(robot, NEVER),
            hosting.excluded.get(robot, ""),
            bool(self._hung[robot]),
            bool(self._suspended[robot]),
            bool(self._disconnected[robot]),
        )

    def expected(self, tick: int) -> Bools:
        """The robots that should take part at a tick: neither absent by schedule nor excluded [n]."""
        expected, _ = self._scheduled(tick)
        expected[list(self.hosting.excluded)] = False
        return expected

    def due(self, tick: int) -> list[int]:
        """The robots that the scenario restarts or wakes at a tick, and that cannot take part yet."""
        scheduled = self._schedule.get(tick)
        if scheduled is None:
            return []
        late = scheduled.back & ~self._answering
        return [robot for robot in np.flatnonzero(late).tolist() if robot not in self.hosting.excluded]

    def missing(self, tick: int) -> str:
        """Reason why a tick cannot begin: no robot that should take part can; else empty."""
        return "no robot is reachable" if not self._answering.any() and self._scheduled(tick)[0].any() else ""

    def begin_run(self, resumed: bool) -> None:
        """The robots have gathered. From now on a lost token costs its robot the tick."""
        if not resumed:
            self.hosting.renewed.clear()
        self.is_running = True

    def token(self, robot: int, alive: bool) -> None:
        """The token of a robot has appeared, or was lost: its next process or session is not hung."""
        self.hosting.token(robot, alive)
        if self.is_running and not alive:
            group = list(self.hosting.group(robot))
            self._hung[group], self._disconnected[group] = False, True

    def silent(self, silent: Bools) -> list[int]:
        """The `silent` robots [n] did not answer in time: they hang, as do all robots of the same process.

        Returns those that hang. Robots whose process or session is gone are absent already, and return with their
        token.
        """
        hung: list[int] = np.flatnonzero(silent & (self.hosting.alive == 1) & ~self._disconnected).tolist()
        for robot in hung:
            self._hung[list(self.hosting.group(robot))] = True
        return hung

    def message(self, robot: int) -> bool:
        """A robot has sent something; True if it was hung until now."""
        is_hung = bool(self._hung[robot])
        if is_hung:
            self._hung[list(self.hosting.group(robot))] = False
        return is_hung

    def begin_tick(self, tick: int, continuing: Bools) -> Bools:
        """The robots that take part in a tick [n], after the messages and tokens until now.

        `continuing` are the robots that took part until now and would keep their state [n]. One of them with another
        session or another process is excluded for one tick; all others start without state anyway.
        """
        expected, self._suspended = self._scheduled(tick)
        able = self._answering & ~(self._disconnected & continuing)
        self._disconnected[:] = False
        if not self.hosting.renewed:  # the usual tick
            return able & expected
        restarted = np.zeros(self.robots, dtype=np.bool_)
        for robot in [robot for robot in self.hosting.renewed if able[robot]]:
            self.hosting.renewed.discard(robot)
            restarted[robot] = continuing[robot]
        return able & expected & ~restarted

    @property
    def _answering(self) -> Bools:
        """Robots that are hosted, and neither excluded nor hung [n]."""
        return self.hosting.able & ~self._hung

    def _scheduled(self, tick: int) -> tuple[Bools, Bools]:
        """The robots that the schedule has neither dead nor hung at a tick, and those hung in a process of their own.

        Both are [n].
        """
        expected, hung = np.ones(self.robots, dtype=np.bool_), np.zeros(self.robots, dtype=np.bool_)
        if not self._schedule:  # the usual run
            return expected, hung
        for start, scheduled in self._schedule.items():
            if start <= tick:
                expected = events.participating(expected, scheduled)
                hung = (hung & ~scheduled.back) | scheduled.hung
        for robot in np.flatnonzero(hung).tolist():
            hung[robot] = len(self.hosting.group(robot)) == 1
        return expected, hung
