"""Consequences of a process's end for its run.

A run ends when its world ends. If an agent dies earlier, its robots are absent and the run continues. It does not
continue if all agents ended with errors, such as that of a law: new ones would end in the same way. Where agents are
restarted, that was tried already, and the world waits for a person. Before the run has begun, the death of an agent
is an error, because the world waits for all robots.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from console.backends.managed_process import ManagedProcess, NotStarted, ended
from console.backends.process_group import DISMISSAL, ProcessGroup
from console.backends.restart_limits import MOST, RestartLimit
from fes.errors import FesError
from fes.process import FAILURE, SUCCESS, UNMET

SETTLING = 2.0
"""Time [s] for the world to end, or for the run to begin, before a dead agent is reported as the cause."""


class ProcessFailed(FesError):
    """A child process failed, and with it the run."""


@dataclass
class Supervisor:
    """Follows the processes of a run to its end."""

    processes: ProcessGroup
    warn: Callable[[str], None]
    """Called with one line for each agent that dies."""
    deserted: str = "no agent is left"
    """The warning when the last agent has ended."""
    respawn: RestartLimit | None = None
    """Limits on restarts of agents that die; None if they are not restarted."""
    _ended: set[ManagedProcess] = field(default_factory=set)
    """The agents whose end has been handled."""

    async def finish(self) -> None:
        """Wait until the world has ended without error, and then up to DISMISSAL for the agents.

        Raises ProcessFailed if the world fails, or a world that resumes the run cannot be started. It also does so
        if an agent ends before the run begins, or if all agents have ended with errors.
        """
        while (
            process := await self.processes.ends.get()
        ) is not self.processes.world or self.processes.successor_due:
            if isinstance(process, NotStarted):
                await self._lose(process.robots, process.verdict(), lived=0.0)
            elif process in self.processes.agents:
                await self._handle_end(process)
        assert isinstance(process, ManagedProcess)  # the world
        if self.processes.not_resumed:
            raise ProcessFailed(self.processes.not_resumed)
        if process not in self.processes.killed and process.process.returncode not in (SUCCESS, UNMET):
            raise ProcessFailed(process.verdict())
        await ended(self.processes.agents, DISMISSAL)

    async def _handle_end(self, agent: ManagedProcess) -> None:
        """Handle the end of an agent while the world runs; raises ProcessFailed."""
        self._ended.add(agent)
        if agent in self.processes.killed or (agent.process.returncode == SUCCESS and agent.was_dismissed):
            return
        await self._lose(agent.robots, agent.verdict(), time.monotonic() - agent.born)

    async def _lose(self, ids: str, why: str, lived: float) -> None:
        """Restart the agent of robots `ids`, which `lived` this long [s], or warn that the run continues without it.

        Raises ProcessFailed if the run cannot begin without it, or if no agent is left to continue it.
        """
        plural, pronoun = ("s", "them") if "-" in ids else ("", "it")
        robots, delay = f"robot{plural} {ids}", None
        if self.respawn is not None:
            delay = self.respawn.delay(ids, lived)
            why += "" if delay else f", {MOST + 1} times in a row: it is not restarted"
        if delay is not None:
            self.warn(f"{robots}: {why}; restarted in {delay:g} s")
            self.processes.restart_agent(ids, delay)
            return
        if not self.processes.has_begun:
            await self._fail(why)
        agents = self.processes.agents
        is_last = self.processes.is_abandoned and self._ended.issuperset(agents)
        if is_last and self.respawn is None and all(agent.process.returncode == FAILURE for agent in agents):
            raise ProcessFailed(f"{why}; no agent is left, and each ended with an error of its own")
        self.warn(f"{robots}: {why}; the run continues without {pronoun}")
        if is_last:
            self.warn(self.deserted)

    async def _fail(self, why: str) -> None:
        """Raise ProcessFailed for an agent before the run begins, or for the world if that ended first.

        Do nothing if the run begins meanwhile.
        """
        world = self.processes.world
        if world is not None and await ended([world], SETTLING) and world.process.returncode != SUCCESS:
            raise ProcessFailed(world.verdict())
        if not self.processes.has_begun:
            raise ProcessFailed(f"{why}; the run cannot begin without it")
