"""Who takes part in a run: all that are there, unless the scenario has them dead or hung."""

import asyncio
import contextlib
import logging
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from fes.arrays.types import Bools
from world.config import events
from world.config.scenario import Scenario
from world.server.registry import AgentRegistry
from world.simulation.truth import State


class Participation:
    """The robots that are there, and those that ought to be."""

    def __init__(
        self, registry: AgentRegistry, scenario: Scenario, excluded: Mapping[int, str] = MappingProxyType({})
    ) -> None:
        """`excluded` maps robots at fault, which take no part, to their faults; it may change later."""
        self._roster, self._excluded = registry, excluded
        self._schedule = scenario.participation
        self._robots = scenario.robots.number
        self._hung = np.zeros(self._robots, dtype=np.bool_)
        self._asleep = np.zeros(self._robots, dtype=np.bool_)
        """Who hangs by the schedule at this tick, and has a process of its own [n]."""
        self._lost = np.zeros(self._robots, dtype=np.bool_)
        """Whose token went since the tick before [n], though it may stand again: what was sent to it went, too."""
        self._logger = logging.getLogger("world")

    @property
    def there(self) -> Bools:
        """Which robots can answer, and all that share their process with them [n].

        Not a process that hangs by the schedule: nothing may wait in its queues. One of several robots goes on, as
        the others' does.
        """
        return self._able & ~self._hung & ~self._asleep & ~self._lost

    def expected(self, state: State) -> Bools:
        """The robots that should take part at the tick of `state`: neither absent by schedule nor excluded [n]."""
        wanted, _ = self._planned(state.tick)
        wanted[list(self._excluded)] = False
        return wanted

    def hang(self, silent: Bools) -> None:
        """The `silent` robots [n] did not answer in time: they are left out, and all that share their process.

        Not those whose process or session is gone: they are out already, and come back with their token.
        """
        for robot in np.flatnonzero(silent & (self._roster.alive == 1) & ~self._lost).tolist():
            self._hung[list(self._roster.group(robot))] = True
            self._logger.warning("robot %d does not answer", robot)

    def lost(self, robot: int) -> None:
        """The process of this robot is gone, or its session: the next one does not hang."""
        group = list(self._roster.group(robot))
        self._hung[group], self._lost[group] = False, True

    def woke(self, robot: int) -> bool:
        """Whether this robot, which was just heard of, was hung until now."""
        hung = bool(self._hung[robot])
        if hung:
            self._hung[list(self._roster.group(robot))] = False
        return hung

    def due(self, state: State) -> list[int]:
        """The robots that the scenario brings back at the tick of `state`, and that cannot take part yet."""
        planned = self._schedule.get(state.tick)
        if planned is None:
            return []
        late = planned.back & ~(self._able & ~self._hung)
        return [robot for robot in np.flatnonzero(late).tolist() if robot not in self._excluded]

    def missing(self, state: State) -> str:
        """Reason why the tick of `state` cannot begin: none of the robots that should take part can; else empty."""
        there = self._able & ~self._hung
        nobody = not there.any() and self._planned(state.tick)[0].any()
        return "nobody is there any more" if nobody else ""

    def now(self, state: State) -> Bools:
        """Who takes part at the tick of `state` [n]."""
        wanted, self._asleep = self._planned(state.tick)
        told: Bools = state.present & (state.since != state.tick)  # who was not is told all anew
        there = self._able & ~self._hung & ~(self._lost & told)
        self._lost[:] = False
        return there & wanted & ~self._begin_anew(state, there)

    async def wait_for(self, present: Bools, timeout: float) -> None:
        """Wait until the robots of `present` [n] are there, for up to `timeout` [s]."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                while not self.there[present].all():
                    self._roster.changed.clear()
                    await self._roster.changed.wait()

    @property
    def _able(self) -> Bools:
        """Robots that are not excluded and whose agents live, as do all that share their process [n]."""
        whole = self._roster.whole
        if not self._excluded:
            return whole
        able = whole.copy()
        able[list(self._excluded)] = False
        return able

    def _begin_anew(self, state: State, there: Bools) -> Bools:
        """Robots that are taken to be there all the time, but have a new process [n]: they miss a tick."""
        anew = np.zeros(self._robots, dtype=np.bool_)
        for robot in [robot for robot in self._roster.renewed if there[robot]]:
            self._roster.renewed.discard(robot)
            anew[robot] = state.present[robot] and state.since[robot] != state.tick
        return anew

    def told(self, before: State, now: State) -> None:
        """Say who came and who went."""
        for robot in np.flatnonzero(before.present & ~now.present).tolist():
            self._logger.info("robot %d is not there from tick %d on: its body stands still", robot, now.tick)
        for robot in np.flatnonzero(now.present & ~before.present).tolist():
            self._logger.info("robot %d is back from tick %d on", robot, now.tick)

    def _planned(self, tick: int) -> tuple[Bools, Bools]:
        """Whom the schedule does not have dead or hung at a tick [n], and who hangs in a process of its own [n]."""
        wanted = np.ones(self._robots, dtype=np.bool_)
        hung = ~wanted
        for at, planned in self._schedule.items():
            if at <= tick:
                wanted = events.participating(wanted, planned)
                hung = (hung & ~planned.back) | planned.hung
        for robot in np.flatnonzero(hung).tolist():
            hung[robot] = len(self._roster.group(robot)) == 1
        return wanted, hung
