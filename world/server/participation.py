"""The robots that take part in a tick: all reachable ones, unless the scenario has them dead or hung."""

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
    """The reachable robots, and the robots that should take part."""

    def __init__(
        self, registry: AgentRegistry, scenario: Scenario, excluded: Mapping[int, str] = MappingProxyType({})
    ) -> None:
        """`excluded` maps robots at fault, which take no part, to their faults; it may change later."""
        self._registry, self._excluded = registry, excluded
        self._schedule = scenario.participation
        self._robots = scenario.robots.number
        self._hung = np.zeros(self._robots, dtype=np.bool_)
        """Robots that did not answer in time, and all robots of the same process [n]."""
        self._suspended = np.zeros(self._robots, dtype=np.bool_)
        """Robots that hang by schedule at this tick, each in a process of its own [n]."""
        self._disconnected = np.zeros(self._robots, dtype=np.bool_)
        """Robots whose token was lost since the last tick [n]. It may have a new
        token, but messages sent in between are lost."""
        self._logger = logging.getLogger("world")

    @property
    def reachable(self) -> Bools:
        """Robots that can answer, as can all robots of the same process [n].

        Excludes processes suspended by schedule, whose queues must stay empty. In a multi-robot process the scheduled
        robot keeps receiving, because its process keeps running.
        """
        return self._able & ~self._hung & ~self._suspended & ~self._disconnected

    def expected(self, state: State) -> Bools:
        """The robots that should take part at the tick of `state`: neither absent by schedule nor excluded [n]."""
        expected, _ = self._scheduled(state.tick)
        expected[list(self._excluded)] = False
        return expected

    def hang(self, silent: Bools) -> None:
        """Exclude the `silent` robots [n], which did not answer in time, and all robots of the same process.

        Robots whose process or session is gone are absent already, and return with their token.
        """
        for robot in np.flatnonzero(silent & (self._registry.alive == 1) & ~self._disconnected).tolist():
            self._hung[list(self._registry.group(robot))] = True
            self._logger.warning("robot %d does not answer", robot)

    def disconnect(self, robot: int) -> None:
        """Note that the process or the session of this robot is gone; its next one is not hung."""
        group = list(self._registry.group(robot))
        self._hung[group], self._disconnected[group] = False, True

    def wake(self, robot: int) -> bool:
        """Note that a robot has sent something; True if it was hung until now."""
        hung = bool(self._hung[robot])
        if hung:
            self._hung[list(self._registry.group(robot))] = False
        return hung

    def due(self, state: State) -> list[int]:
        """The robots that the scenario restarts or wakes at the tick of `state`, and that cannot take part yet."""
        scheduled = self._schedule.get(state.tick)
        if scheduled is None:
            return []
        late = scheduled.back & ~(self._able & ~self._hung)
        return [robot for robot in np.flatnonzero(late).tolist() if robot not in self._excluded]

    def missing(self, state: State) -> str:
        """Reason why the tick of `state` cannot begin: no robot that should take part can; else empty."""
        able = self._able & ~self._hung
        return "no robot is reachable" if not able.any() and self._scheduled(state.tick)[0].any() else ""

    def participating(self, state: State) -> Bools:
        """The robots that take part at the tick of `state` [n]."""
        expected, self._suspended = self._scheduled(state.tick)
        has_state: Bools = state.present & (state.since != state.tick)  # other robots start without state anyway
        able = self._able & ~self._hung & ~(self._disconnected & has_state)
        self._disconnected[:] = False
        return able & expected & ~self._restarted(state, able)

    async def wait_for(self, robots: Bools, timeout: float) -> None:
        """Wait until `robots` [n] are reachable, for up to `timeout` [s]."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                while not self.reachable[robots].all():
                    self._registry.changed.clear()
                    await self._registry.changed.wait()

    @property
    def _able(self) -> Bools:
        """Robots that are not excluded and whose agents are alive, as are all of the same process [n]."""
        hosted = self._registry.hosted
        if not self._excluded:
            return hosted
        able = hosted.copy()
        able[list(self._excluded)] = False
        return able

    def _restarted(self, state: State, able: Bools) -> Bools:
        """Robots that took part until now, but have a new process [n]: they are excluded for one tick."""
        restarted = np.zeros(self._robots, dtype=np.bool_)
        for robot in [robot for robot in self._registry.renewed if able[robot]]:
            self._registry.renewed.discard(robot)
            restarted[robot] = state.present[robot] and state.since[robot] != state.tick
        return restarted

    def log_changes(self, before: State, after: State) -> None:
        """Log the robots that take part in only one of two states."""
        for robot in np.flatnonzero(before.present & ~after.present).tolist():
            self._logger.info("robot %d is absent from tick %d on: its body stands still", robot, after.tick)
        for robot in np.flatnonzero(after.present & ~before.present).tolist():
            self._logger.info("robot %d is back from tick %d on", robot, after.tick)

    def _scheduled(self, tick: int) -> tuple[Bools, Bools]:
        """The robots that the schedule has neither dead nor hung at a tick, and those hung in a process of their own.

        Both are [n].
        """
        expected = np.ones(self._robots, dtype=np.bool_)
        hung = ~expected
        for start, scheduled in self._schedule.items():
            if start <= tick:
                expected = events.participating(expected, scheduled)
                hung = (hung & ~scheduled.back) | scheduled.hung
        for robot in np.flatnonzero(hung).tolist():
            hung[robot] = len(self._registry.group(robot)) == 1
        return expected, hung
