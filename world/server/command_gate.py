"""Gate for commands: only the process accepted for a robot passes, not another one with the same certificate."""

from collections.abc import Mapping

from fes.protocol import keys
from fes.protocol.messages import Join


class CommandGate:
    """Admits a Command by the mark attached to it, which only the agent that joined knows.

    `admits` runs in threads of Zenoh, before a message is queued. So a flood of commands from another process of the
    same robot neither fills a queue nor wakes the world.
    """

    def __init__(self, run: str, hosts: Mapping[int, Join]) -> None:
        """`hosts`: robot -> the last Join that was accepted for it."""
        self._run = run
        self._marks: dict[str, bytes] = {}
        self.rejected = 0
        """Number of commands that were not admitted."""
        for robot, join in hosts.items():  # another robot of the same Join may have a newer agent
            self._marks[keys.command(run, robot)] = join.mark

    def expect(self, join: Join) -> None:
        """From now on admit the commands of this agent, and of no earlier one."""
        for robot in join.robots:
            self._marks[keys.command(self._run, robot)] = join.mark

    def admits(self, key: str, mark: bytes) -> bool:
        """True if a sample on `key` with this mark comes from the accepted agent."""
        if self._marks.get(key) == mark:
            return True
        self.rejected += 1
        return False
