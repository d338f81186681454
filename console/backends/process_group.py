"""The processes of a run: a world and its agents, all of which end with the run."""

import asyncio
import contextlib
import os
import random
import signal
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from console.backends import managed_process
from console.backends.managed_process import ManagedProcess, NotStarted, ended
from fes.errors import reason
from fes.extension import registry
from world.execution.checkpoint import has_checkpoint

DISMISSAL = 2.0
"""Time [s] after the end of the world in which dismissed agents end by themselves; then they get a signal."""

CLOSING = 15.0
"""Time [s] that a world has to write its results after a signal; a second signal does not wait."""

GRACE = 3.0
"""Time [s] that children have to end after a signal, before they are killed."""

BEGUN = b"all robots are here"
"""Text that the world logs when the run begins."""


class ProcessGroup:
    """A world and its agents."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.world: ManagedProcess | None = None
        self.agents: list[ManagedProcess] = []
        self.killed: set[ManagedProcess] = set()
        """Children killed by schedule, whose end is not a failure."""
        self.successor_due = False
        """True while another world is about to resume the run."""
        self.not_resumed = ""
        """Reason in one line why no other world resumes the run; empty otherwise."""
        self.ends: asyncio.Queue[ManagedProcess | NotStarted] = asyncio.Queue()
        """The children that have ended, and the agents that could not be restarted, in order."""
        self._begun = False
        self._arguments: dict[str, list[str]] = {}
        """Arguments of each agent's last start, by its robots."""
        self._watches: set[asyncio.Task[None]] = set()
        self._restarts: dict[str, asyncio.Task[None]] = {}
        """Agents that are about to be restarted, by their robots."""

    @property
    def processes(self) -> list[ManagedProcess]:
        """The world and the agents."""
        return ([self.world] if self.world else []) + self.agents

    @property
    def has_begun(self) -> bool:
        """True once all robots have joined and the run has begun; also if the world's log cannot be read."""
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
        words = [*arguments, *_use_flags()]
        self.world = await managed_process.start("fes-world", "world", words, self.directory / "world.log")
        self.watch(self.world)

    async def start_agent(self, robots: str, arguments: list[str]) -> None:
        """Start fes-agent for `robots`, unless it runs already."""
        self._cancel_restart(robots)
        self._arguments[robots] = arguments
        await self._start_agent(robots)

    async def start_agent_again(self, robots: str) -> None:
        """Restart the agent of `robots` with its former arguments; if that fails, `ends` has the reason."""
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
        """Kill the agent of `robots` by schedule: its end is not a failure."""
        self._cancel_restart(robots)
        for agent in self.agents:
            if agent.robots == robots and agent.runs:
                self.killed.add(agent)
                agent.signal(signal.SIGKILL)
                await agent.process.wait()

    async def replace_world(self, seconds: float, arguments: list[str]) -> None:
        """Kill the world by schedule, and start another after this time [s]: its end is not a failure.

        If another cannot be started, `not_resumed` has the reason.
        """
        world = self.world
        if world is None or not world.runs:
            return
        # Before the signal, so that its end counts neither as a failure nor as the end of the run.
        self.killed.add(world)
        self.successor_due = True
        try:
            world.signal(signal.SIGKILL)
            if await world.process.wait() >= 0:  # it ended by itself just before
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
        """Put a child into `ends` once it has ended."""

        async def watch() -> None:
            await watched.process.wait()
            self.ends.put_nowait(watched)

        task = asyncio.ensure_future(watch())
        self._watches.add(task)
        task.add_done_callback(self._watches.discard)

    async def stop(self) -> None:
        """End every child: the world first, which dismisses the agents; then the others, by SIGKILL after GRACE."""
        await self._cancel_restarts()
        if self.world is not None and self.world.runs:
            self.world.signal(signal.SIGINT)  # after SIGTERM the agents would wait for a resumed world
            self.world.signal(signal.SIGCONT)  # a suspended process acts on no other signal
            if not self.has_begun:
                self._terminate_agents()  # a world dismisses only the agents that have joined
            await ended([self.world], CLOSING)
            await ended(self.agents, DISMISSAL)
        self._terminate_agents()
        if not await ended(self.processes, GRACE):
            self.kill()
            await ended(self.processes, GRACE)
        for task in self._watches:
            task.cancel()

    def kill(self) -> None:
        """Kill every child."""
        for child in self.processes:
            child.signal(signal.SIGKILL)

    def abandon(self) -> None:
        """Kill every child, and wait until all have ended.

        It does not wait on a system without os.waitid, because any other call would reap a child before asyncio does.
        """
        self.kill()
        if hasattr(os, "waitid"):
            for child in self.processes:
                with contextlib.suppress(OSError):
                    os.waitid(os.P_PID, child.process.pid, os.WEXITED | os.WNOWAIT)

    async def _start_agent(self, robots: str) -> None:
        if any(agent.robots == robots and agent.runs for agent in self.agents):
            return
        words, log = ["--id", robots, *self._arguments[robots], *_use_flags()], self.directory / f"agent-{robots}.log"
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

    def _terminate_agents(self) -> None:
        """Send SIGTERM to the agents, suspended ones included."""
        for agent in self.agents:
            agent.signal(signal.SIGTERM)
            agent.signal(signal.SIGCONT)


@asynccontextmanager
async def ended_with_block(group: ProcessGroup) -> AsyncIterator[None]:
    """A block after which all children have ended, also after an error."""
    try:
        yield
    finally:
        # Shielded against a cancellation meanwhile. If this process is killed, the standard input of its children
        # ends, and they end too.
        await asyncio.shield(group.stop())


PORTS = range(20_000, 32_000)
"""Ports for worlds that this machine starts."""


def free_port() -> int:
    """A free TCP port of the loopback interface; raises OSError if there is none.

    Linux and macOS give the ports of PORTS to no outgoing connection. So the port stays free while its world is
    restarted.
    """
    for port in random.sample(PORTS, 100):
        with contextlib.suppress(OSError), socket.socket() as probe:
            probe.bind(("127.0.0.1", port))
            return port
    raise OSError("no free port on 127.0.0.1")


def _use_flags() -> list[str]:
    """The flags that allow a child the extensions of this process."""
    return [word for module in registry.used() for word in ("--use", module)]
