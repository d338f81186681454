"""Consequences of a child's end for its run.

A run ends when its world ends. If an agent dies before that, its robots are absent, as they may be by schedule, and
the run does not fail. The exception is a run that has not begun: its world waits for all robots.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from console.backends.managed_process import ManagedProcess, NotStarted, ended
from console.backends.process_group import DISMISSAL, ProcessGroup
from console.backends.restart_limits import MOST, RestartLimit
from fes.errors import FesError
from fes.process import SUCCESS, UNMET

SETTLING = 2.0
"""Time [s] for the world to end, or for the run to begin, before a dead agent is held to be the cause."""


class ProcessFailed(FesError):
    """A child process ended as it should not have, and its run with it."""


@dataclass
class Supervisor:
    """Follows the children of a run to its end."""

    processes: ProcessGroup
    warn: Callable[[str], None]
    """Called with one line for each agent that dies."""
    deserted: str = "no agent is left"
    """The line for a run of which no agent is left."""
    respawn: RestartLimit | None = None
    """Limits on restarts of agents that die; None if they are not restarted."""
    _ended: set[ManagedProcess] = field(default_factory=set)
    """The agents whose end is known here."""

    async def finish(self) -> None:
        """Wait until the world has ended well, and for a moment for the agents that it dismissed.

        Raises ChildFailed if the world ended badly, if the one that was to resume its run cannot be started, or if an
        agent ended without which it cannot begin.
        """
        while (gone := await self.processes.ends.get()) is not self.processes.world or self.processes.successor_due:
            if isinstance(gone, NotStarted):
                await self._lose(gone.robots, gone.verdict(), lived=0.0)
            elif gone in self.processes.agents:
                await self._miss(gone)
        assert isinstance(gone, ManagedProcess)  # it is the world
        if self.processes.not_resumed:
            raise ProcessFailed(self.processes.not_resumed)
        if gone not in self.processes.killed and gone.process.returncode not in (SUCCESS, UNMET):
            raise ProcessFailed(gone.verdict())
        await ended(self.processes.agents, DISMISSAL)

    async def _miss(self, agent: ManagedProcess) -> None:
        """Handle the end of an agent while the world runs; raises ChildFailed."""
        self._ended.add(agent)
        if agent in self.processes.killed or (agent.process.returncode == SUCCESS and agent.was_dismissed):
            return
        await self._lose(agent.robots, agent.verdict(), time.monotonic() - agent.born)

    async def _lose(self, ids: str, why: str, lived: float) -> None:
        """Restart the agent of robots `ids`, which `lived` this long [s], or say that the run continues without it.

        Raises ChildFailed if the run cannot begin without it.
        """
        plural, whom = ("s", "them") if "-" in ids else ("", "it")
        robots, delay = f"robot{plural} {ids}", None
        if self.respawn is not None:
            delay = self.respawn.delay(ids, lived)
            why += "" if delay else f", {MOST + 1} times in a row: it is not started again"
        if delay is not None:
            self.warn(f"{robots}: {why}; started again in {delay:g} s")
            self.processes.restart_agent(ids, delay)
            return
        if not self.processes.has_begun:
            await self._blame(why)
        self.warn(f"{robots}: {why}; the run continues without {whom}")
        if self.processes.is_abandoned and self._ended.issuperset(self.processes.agents):
            self.warn(self.deserted)

    async def _blame(self, why: str) -> None:
        """Raise ChildFailed for an agent without which the run cannot begin, or for the world, if that ended first.

        Do nothing if the run begins just then.
        """
        world = self.processes.world
        if world is not None and await ended([world], SETTLING) and world.process.returncode != SUCCESS:
            raise ProcessFailed(world.verdict())
        if not self.processes.has_begun:
            raise ProcessFailed(f"{why}; the run cannot begin without it")
