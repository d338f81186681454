"""What the end of a child means for its run.

The run is its world's: it ends when the world ends. An agent that dies before that is an absence of its robots, as by
schedule, and no failure of the run; unless the run has not begun, since its world waits for all robots then.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from console.child import Child, ended
from console.launcher import DISMISSAL, Family
from console.respawn import MOST, Respawn
from fes.errors import FesError
from fes.process import SUCCESS, UNMET

SETTLING = 2.0
"""Time [s] for the world to end, or for the run to begin, before a dead agent is held to be the cause."""


class ChildFailed(FesError):
    """A child process ended as it should not have, and its run with it."""


@dataclass
class Supervisor:
    """Follows the children of a run to its end."""

    family: Family
    warn: Callable[[str], None]
    """Told of each agent that dies, in one line."""
    deserted: str = "no agent is left"
    """Said when none is left."""
    respawn: Respawn | None = None
    """How agents that die are started again; None: they are not."""
    _ended: set[Child] = field(default_factory=set)
    """The agents of whose end this knows."""

    async def finish(self) -> None:
        """Wait until the world has ended well, and for a moment for the agents that it dismissed.

        Raises ChildFailed if the world ended badly, or if an agent ended for which it still waits to begin.
        """
        while (gone := await self.family.ends.get()) is not self.family.world or self.family.successor_due:
            if gone in self.family.agents:
                await self._miss(gone)
        if gone not in self.family.killed and gone.process.returncode not in (SUCCESS, UNMET):
            raise ChildFailed(gone.verdict())
        await ended(self.family.agents, DISMISSAL)

    async def _miss(self, agent: Child) -> None:
        """What follows from the end of an agent while the world goes on; raises ChildFailed."""
        self._ended.add(agent)
        if agent in self.family.killed or (agent.process.returncode == SUCCESS and agent.was_dismissed):
            return
        plural, whom = ("s", "them") if "-" in agent.robots else ("", "it")
        robots, why = f"robot{plural} {agent.robots}", agent.verdict()
        lived, delay = time.monotonic() - agent.born, None
        if self.respawn is not None:
            delay = self.respawn.delay(agent.robots, lived)
            why += "" if delay else f", {MOST + 1} times in a row: it is not started again"
        if delay is not None:
            self.warn(f"{robots}: {why}; started again in {delay:g} s")
            self.family.restart_agent(agent.robots, delay)
            return
        if not self.family.has_begun:
            await self._blame(why)
        self.warn(f"{robots}: {why}; the run continues without {whom}")
        if self.family.is_deserted and self._ended.issuperset(self.family.agents):
            self.warn(self.deserted)

    async def _blame(self, why: str) -> None:
        """Raises ChildFailed for an agent without which the run cannot begin; or for the world, if that ended first.

        It does not if the run begins just then.
        """
        world = self.family.world
        if world is not None and await ended([world], SETTLING) and world.process.returncode != SUCCESS:
            raise ChildFailed(world.verdict())
        if not self.family.has_begun:
            raise ChildFailed(f"{why}; the run cannot begin without it")
