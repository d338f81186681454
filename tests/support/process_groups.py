"""Stand-ins for the processes of `fes run`, in a group that ends them."""

import asyncio
import contextlib
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from pathlib import Path

from console.backends import process_group
from console.backends.managed_process import ManagedProcess
from console.backends.process_group import ProcessGroup
from console.backends.restart_limits import RestartLimit
from console.backends.supervisor import ProcessFailed, Supervisor

ENDLESS = "import signal; signal.pause()"
SUCCESS, FAILURE = "raise SystemExit(0)", "raise SystemExit(1)"

SLOW = """
import asyncio, os, sys
from pathlib import Path
from fes import process

async def main():
    Path("here").touch()
    try:
        await asyncio.Event().wait()
    finally:
        while not Path("go").exists():
            await asyncio.sleep(0.01)
        Path("kept").touch()
    return 0

process.run("slow", main, exit_with_stdin=True)
"""
"""Code of a world that writes its results when permitted."""


@contextlib.asynccontextmanager
async def family(where: Path) -> AsyncIterator[ProcessGroup]:
    processes = ProcessGroup(where)
    async with process_group.ended_with_block(processes):
        yield processes


async def child(where: Path, name: str, code: str, messages: str = "", robots: str = "") -> ManagedProcess:
    """A stand-in for a program; `messages` is in its log."""
    log = where / f"{name}.log"
    log.write_text(messages)
    started = await asyncio.create_subprocess_exec(sys.executable, "-c", code, stdin=subprocess.PIPE, cwd=where)
    return ManagedProcess(name, started, log, robots)


async def world(processes: ProcessGroup, code: str, messages: str = "") -> None:
    processes.world = await child(processes.directory, "fes-world", code, messages)
    processes.watch(processes.world)


async def agent(processes: ProcessGroup, robots: str, code: str, messages: str = "") -> ManagedProcess:
    processes.agents.append(await child(processes.directory, f"fes-agent --id {robots}", code, messages, robots))
    processes.watch(processes.agents[-1])
    return processes.agents[-1]


async def until(holds: Callable[[], object]) -> None:
    async with asyncio.timeout(60.0):
        while not holds():
            await asyncio.sleep(0.01)


async def finished(processes: ProcessGroup, respawn: RestartLimit | None = None) -> tuple[str, list[str]]:
    """The error of a run, if it failed, and its warnings."""
    messages: list[str] = []
    try:
        await Supervisor(processes, messages.append, "nobody is left", respawn).finish()
    except ProcessFailed as failed:
        return str(failed), messages
    return "", messages


class Impatient(RestartLimit):
    """Two immediate restarts."""

    def delay(self, robots: str, lived: float) -> float | None:
        return 0.01 if super().delay(robots, 0.0) in (0.5, 1.0) else None


class Tireless(RestartLimit):
    """Immediate restarts without end."""

    def delay(self, robots: str, lived: float) -> float | None:
        return 0.01
