"""The processes of a run: a world and its agents, started together and never left behind."""

import asyncio
import contextlib
import os
import signal
import socket
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

from console.backends import managed_process
from console.backends.managed_process import ManagedProcess, NotStarted, ended
from fes.errors import reason
from world.execution.checkpoint import has_checkpoint

DISMISSAL = 2.0
"""Time [s] in which dismissed agents must end by themselves after their world has left; then they are told to."""

CLOSING = 15.0
"""Time [s] that a world that is told to stop has to write down what was reached; a second signal does not wait."""

GRACE = 3.0
"""Time [s] that children that are told to end have, before they are ended by force."""

BEGUN = b"all robots are here"
"""The world logs this when the run begins."""


class ProcessGroup:
    """A world and its agents."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.world: ManagedProcess | None = None
        self.agents: list[ManagedProcess] = []
        self.killed: set[ManagedProcess] = set()
        """Children killed by us, as the scenario wants: they are not missed."""
        self.successor_due = False
        """True while another world is about to resume the run."""
        self.not_resumed = ""
        """Reason why no other world resumes the run, in one line; empty if there is none."""
        self.ends: asyncio.Queue[ManagedProcess | NotStarted] = asyncio.Queue()
        """The children that have ended, and the agents that could not be started again, in order."""
        self._begun = False
        self._arguments: dict[str, list[str]] = {}
        """Arguments of each agent's last start, by its robots."""
        self._watches: set[asyncio.Task[None]] = set()
        self._restarts: dict[str, asyncio.Task[None]] = {}
        """Agents that are about to be restarted, by their robots."""

    @property
    def processes(self) -> list[ManagedProcess]:
        """All of them."""
        return ([self.world] if self.world else []) + self.agents

    @property
    def has_begun(self) -> bool:
        """True once the world has had all robots, and the run has begun; also if its log cannot be read."""
        if self.world is not None and not self._begun:
            try:
                self._begun = BEGUN in self.world.log.read_bytes()
            except OSError:
                return True
        return self._begun

    @property
    def is_abandoned(self) -> bool:
        """True if no agent runs, and none is about to be restarted."""
        return not self._restarts and not any(agent.runs for agent in self.agents)

    async def start_world(self, arguments: list[str]) -> None:
        """Start fes-world."""
        self.world = await managed_process.start("fes-world", "world", arguments, self.directory / "world.log")
        self.watch(self.world)

    async def start_agent(self, robots: str, arguments: list[str]) -> None:
        """Start fes-agent for `robots`, unless it runs already."""
        self._cancel_restart(robots)
        self._arguments[robots] = arguments
        await self._start_agent(robots)

    async def start_agent_again(self, robots: str) -> None:
        """Start the agent of `robots` as it was started before; if the system cannot, `ends` has the reason."""
        self._cancel_restart(robots)
        await self._try_to_start_agent(robots)

    def restart_agent(self, robots: str, delay: float) -> None:
        """Restart the agent of `robots`, which has ended, after a `delay` [s]."""

        async def restart() -> None:
            await asyncio.sleep(delay)
            await self._try_to_start_agent(robots)
            self._restarts.pop(robots, None)

        self._cancel_restart(robots)
        self._restarts[robots] = asyncio.ensure_future(restart())

    async def kill_agent(self, robots: str) -> None:
        """End the agent of `robots` by SIGKILL, as its scenario wants; it is not missed."""
        self._cancel_restart(robots)
        for agent in self.agents:
            if agent.robots == robots and agent.runs:
                self.killed.add(agent)
                agent.signal(signal.SIGKILL)
                await agent.process.wait()

    async def replace_world(self, seconds: float, arguments: list[str]) -> None:
        """End the world by SIGKILL, as its scenario wants, and start another after a while [s]; it is not missed.

        If the system cannot start another, `not_resumed` has the reason.
        """
        world = self.world
        if world is None or not world.runs:
            return
        self.killed.add(world)  # first, so that its end is not taken for a failure, or for the end of the run
        self.successor_due = True
        try:
            world.signal(signal.SIGKILL)
            if await world.process.wait() >= 0:  # it had just ended by itself
                self.killed.discard(world)
            elif has_checkpoint(self.directory):
                await asyncio.sleep(seconds)
                await self.start_world(arguments)
        except OSError as error:
            self.not_resumed = f"fes-world cannot be started: {reason(error)}"
        finally:
            self.successor_due = False
            if self.world is world:
                self.ends.put_nowait(world)  # no other world follows

    def stop_agent(self, robots: str) -> None:
        """Suspend the agent of `robots`, as if it hung."""
        self._signal_agent(robots, signal.SIGSTOP)

    def continue_agent(self, robots: str) -> None:
        """Resume the agent of `robots`."""
        self._signal_agent(robots, signal.SIGCONT)

    def watch(self, watched: ManagedProcess) -> None:
        """Put a child into `ends` when it has ended."""

        async def watch() -> None:
            await watched.process.wait()
            self.ends.put_nowait(watched)

        task = asyncio.ensure_future(watch())
        self._watches.add(task)
        task.add_done_callback(self._watches.discard)

    async def stop(self) -> None:
        """End every child: the world first, which dismisses the agents; then the others, by force after GRACE."""
        await self._cancel_restarts()
        if self.world is not None and self.world.runs:
            self.world.signal(signal.SIGINT)  # after SIGTERM the agents would wait for a resumed world
            self.world.signal(signal.SIGCONT)  # a stopped process hears nothing else
            if not self.has_begun:
                self._tell_agents()  # a world may dismiss only those that have joined it
            await ended([self.world], CLOSING)
            await ended(self.agents, DISMISSAL)
        self._tell_agents()
        if not await ended(self.processes, GRACE):
            self.kill()
            await ended(self.processes, GRACE)
        for task in self._watches:
            task.cancel()

    def kill(self) -> None:
        """End every child by force, at once."""
        for one in self.processes:
            one.signal(signal.SIGKILL)

    def abandon(self) -> None:
        """End every child by force, and wait until they have ended (if the system can wait and leave it to asyncio to
        reap them)."""
        self.kill()
        if hasattr(os, "waitid"):
            for one in self.processes:
                with contextlib.suppress(OSError):
                    os.waitid(os.P_PID, one.process.pid, os.WEXITED | os.WNOWAIT)

    async def _start_agent(self, robots: str) -> None:
        if any(agent.robots == robots and agent.runs for agent in self.agents):
            return
        words, log = ["--id", robots, *self._arguments[robots]], self.directory / f"agent-{robots}.log"
        agent = await managed_process.start(f"fes-agent --id {robots}", "agents", words, log, robots)
        self.agents.append(agent)
        self.watch(agent)

    async def _try_to_start_agent(self, robots: str) -> None:
        try:
            await self._start_agent(robots)
        except OSError as error:
            self.ends.put_nowait(NotStarted(f"fes-agent --id {robots}", robots, reason(error)))

    def _cancel_restart(self, robots: str) -> None:
        if (restart := self._restarts.pop(robots, None)) is not None:
            restart.cancel()

    async def _cancel_restarts(self) -> None:
        """Cancel all restarts, and wait until none of them is starting a process."""
        restarts = list(self._restarts.values())
        self._restarts.clear()
        for restart in restarts:
            restart.cancel()
        await asyncio.gather(*restarts, return_exceptions=True)

    def _signal_agent(self, robots: str, number: signal.Signals) -> None:
        for agent in self.agents:
            if agent.robots == robots:
                agent.signal(number)

    def _tell_agents(self) -> None:
        """Tell the agents to end."""
        for agent in self.agents:
            agent.signal(signal.SIGTERM)
            agent.signal(signal.SIGCONT)


@asynccontextmanager
async def ended_with_block(family: ProcessGroup) -> AsyncIterator[None]:
    """A block at whose end all children end, however it ends."""
    try:
        yield
    finally:
        # Shielded against a cancellation while it waits. If all of this process ends, so does its end of the
        # children's standard input, which ends them too.
        await asyncio.shield(family.stop())


def free_port() -> int:
    """A TCP port of the loopback interface that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def share(robots: int, per_process: int) -> Iterator[str]:
    """Robot ids for each agent process, `per_process` at a time.

    >>> list(share(5, 2))
    ['0-1', '2-3', '4']
    """
    for first in range(0, robots, per_process):
        last = min(first + per_process, robots) - 1
        yield str(first) if first == last else f"{first}-{last}"
