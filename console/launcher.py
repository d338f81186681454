"""Child processes: a world and its agents, started together and never left behind."""

import asyncio
import contextlib
import os
import signal
import socket
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from fes import encoding
from fes.errors import FesError
from fes.process import SUCCESS, UNMET
from world.checkpoint import is_kept

DISMISSAL = 5.0
"""Time [s] that agents have to end after their world dismissed them and left."""

SETTLING = 2.0
"""Time [s] for the others to end after one child failed, before the cause is told."""

CLOSING = 15.0
"""Time [s] that a world that is told to stop has to write down what was reached; a second signal does not wait."""

GRACE = 3.0
"""Time [s] that children have to end by themselves before they are ended."""


class ChildFailed(FesError):
    """A child process ended as it should not have."""


@dataclass(frozen=True, eq=False)
class Child:
    """One child process."""

    name: str
    process: asyncio.subprocess.Process
    log: Path
    """Its standard error."""

    def verdict(self) -> str:
        """How it ended, with the last line it said."""
        code = self.process.returncode
        how = f"was ended by {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit code {code}"
        lines = self.log.read_text(errors="replace").strip().splitlines()
        said = lines[-1].removeprefix(f"{self.name.split()[0]}: error: ") if lines and code == 1 else ""
        return said or f"{self.name} {how} (its log: {self.log})"


class Family:
    """A world and its agents."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.world: Child | None = None
        self.agents: list[Child] = []
        self._killed: set[Child] = set()
        self._successor_due = False
        """Whether another world is about to go on with the run."""
        self._grown = asyncio.Event()
        """Set whenever a child was started."""
        self._logs: list[IO[bytes]] = []

    @property
    def children(self) -> list[Child]:
        """All of them."""
        return ([self.world] if self.world else []) + self.agents

    async def start_world(self, arguments: list[str]) -> None:
        """Start fes-world."""
        self.world = await self._start("fes-world", "world.process", arguments, "world")

    async def start_agent(self, ids: str, arguments: list[str]) -> None:
        """Start fes-agent for `ids`."""
        child = await self._start(
            f"fes-agent --id {ids}", "agents.process", ["--id", ids, *arguments], f"agent-{ids}"
        )
        self.agents.append(child)
        self._grown.set()

    async def kill_agent(self, ids: str) -> None:
        """End the agent of `ids` by SIGKILL, as its scenario wants; it is not missed."""
        for child in self.agents:
            if child.name == f"fes-agent --id {ids}" and child.process.returncode is None:
                self._killed.add(child)
                _signal(child, signal.SIGKILL)
                await child.process.wait()

    async def replace_world(self, seconds: float, arguments: list[str]) -> None:
        """End the world by SIGKILL, as its scenario wants, and start another after a while [s]; it is not missed."""
        if self.world is None or self.world.process.returncode is not None:
            return
        self._killed.add(self.world)  # first: nobody is to think that it failed, or that all is over
        self._successor_due = True
        _signal(self.world, signal.SIGKILL)
        if await self.world.process.wait() >= 0 or not is_kept(self.directory):
            self._successor_due = False  # it was over just then
            self._grown.set()
            return
        await asyncio.sleep(seconds)
        await self.start_world(arguments)
        self._successor_due = False
        self._grown.set()

    def stop_agent(self, ids: str) -> None:
        """Have the agent of `ids` go no further, as one that hangs."""
        self._signal_agent(ids, signal.SIGSTOP)

    def continue_agent(self, ids: str) -> None:
        """Have the agent of `ids` go on."""
        self._signal_agent(ids, signal.SIGCONT)

    def _signal_agent(self, ids: str, number: signal.Signals) -> None:
        for child in self.agents:
            if child.name == f"fes-agent --id {ids}":
                _signal(child, number)

    async def finish(self) -> None:
        """Wait until the world and all agents have ended well; raises ChildFailed for the first that did not.

        If an agent dies, the world names it; so the world's word is heard first.
        """
        assert self.world is not None
        waits: dict[asyncio.Task[int], Child] = {}
        grown = asyncio.ensure_future(self._grown.wait())
        try:
            while True:
                known = set(waits.values())
                waits |= {asyncio.ensure_future(one.process.wait()): one for one in self.children if one not in known}
                pending = [task for task in waits if not task.done()]
                failed = [
                    child for task, child in waits.items() if task.done() and not self._well(child, task.result())
                ]
                if failed:
                    raise ChildFailed(await self._explain(failed[0]))
                if not pending and not self._successor_due:
                    return
                if self._is_over() and not await _gone(self.agents, DISMISSAL):
                    return  # they wait for a world that nobody brings back
                await asyncio.wait([*pending, grown], return_when=asyncio.FIRST_COMPLETED)
                if grown.done():
                    self._grown.clear()
                    grown = asyncio.ensure_future(self._grown.wait())
        finally:
            for task in (*waits, grown):
                task.cancel()

    def _is_over(self) -> bool:
        """Whether the world ended well, by itself or by a signal."""
        gone = self.world is not None and self.world.process.returncode is not None
        return gone and not self._successor_due

    def _well(self, child: Child, code: int) -> bool:
        return code in (SUCCESS, UNMET) or child in self._killed

    async def stop(self) -> None:
        """End every child: the world first, which dismisses the agents; what is left then, after GRACE, by force."""
        if self.world is not None and self.world.process.returncode is None:
            _signal(self.world, signal.SIGINT)  # SIGTERM would let the agents wait for a world that goes on
            await _gone([self.world], CLOSING)
            if await _gone(self.children, DISMISSAL):
                return
        for child in self.agents:
            _signal(child, signal.SIGTERM)
        if not await _gone(self.children, GRACE):
            for child in self.children:
                _signal(child, signal.SIGKILL)
            await _gone(self.children, GRACE)

    async def _explain(self, failed: Child) -> str:
        """Why the run failed: a child that was ended by force, but not by us, or else what the world says of it."""
        # Which exit is noticed first is chance, and the others follow at once: so all are looked at.
        await _gone(self.children, SETTLING)
        ended = [(child, child.process.returncode) for child in self.children]
        bad = {child: code for child, code in ended if code is not None and not self._well(child, code)}
        forced = next((child for child, code in bad.items() if code < 0), None)
        if self.world is None or self.world not in bad:
            return (forced or failed).verdict()
        said = self.world.verdict()
        return said if forced is None or forced is self.world else f"{forced.verdict()}; the world: {said}"

    async def _start(self, name: str, module: str, arguments: list[str], log: str) -> Child:
        path = self.directory / f"{log}.log"
        with path.open("ab") as stream:
            process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-P",  # a folder called `world` where the person stands is not ours
                "-m",
                module,
                *map(encoding.as_bytes, arguments),
                "--exit-with-stdin",
                stdin=asyncio.subprocess.PIPE,  # never written to: its end tells the child that we are gone
                stdout=stream,
                stderr=stream,
                start_new_session=True,  # a Ctrl-C reaches us, and we end the children in order
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )
        return Child(name, process, path)


@asynccontextmanager
async def family(directory: Path) -> AsyncIterator[Family]:
    """A family whose children all end with the block, however it ends."""
    kin = Family(directory)
    try:
        yield kin
    finally:
        # Shielded against a cancellation while it waits. If all of this process ends, so does its end of the
        # children's standard input, which ends them too.
        await asyncio.shield(kin.stop())


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


def _signal(child: Child, number: signal.Signals) -> None:
    """Send a signal, unless the child has ended.

    Not through Popen: it would look whether the child has ended, and take its exit status away from asyncio.
    """
    if child.process.returncode is None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(child.process.pid, number)


async def _gone(children: list[Child], timeout: float) -> bool:
    """Whether all of them ended within `timeout` [s]."""
    try:
        async with asyncio.timeout(timeout):
            for child in children:
                await child.process.wait()
    except TimeoutError:
        return False
    return True
