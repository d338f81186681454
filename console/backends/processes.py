"""fes run with real processes: one world, its agents, and whoever watches."""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from console.backends import fault_injection, process_group
from console.backends.process_group import ProcessGroup
from console.backends.restart_limits import RestartLimit
from console.backends.supervisor import Supervisor
from console.connect import observer, run_directory
from console.connect.run_directory import Address, RunDirectory
from console.dashboard import live
from console.dashboard.summary import BELOW
from console.doctor import machine
from console.doctor.finding import Status
from console.keys import command as keys_command
from console.terminal import progress
from console.terminal.printing import is_screen
from fes import process
from fes.errors import FesError
from fes.protocol import keys
from fes.system import files, signals, strict_json
from fes.transport import bus, identity
from fes.transport.endpoints import Endpoints
from world.config.scenario import Scenario
from world.server.lockstep import RETURN_TIMEOUT

RUN = keys.DEFAULT_RUN
MAX_SUMMARY = 1 << 30
"""Largest summary that is read [bytes]; that of a hundred robots has 100 kB."""

JOIN_TIMEOUT = 60.0
"""How long children look for the world [s]; a loaded machine starts ten interpreters slowly."""


@dataclass(frozen=True)
class Launch:
    """How a run is to be started."""

    name: str
    """Name of the scenario."""
    agents_per_process: int
    rtf: str
    dashboard: bool
    record: bool
    secure: bool = False
    """With TLS, and certificates made for this run."""
    respawn: bool = False
    """True if agents that die are restarted."""

    def groups(self, robots: int) -> list[str]:
        """The robot ids of each agent process."""
        return list(process_group.share(robots, self.agents_per_process))


def check(launch: Launch, scenario: Scenario) -> None:
    """Raise FesError, in the words of `fes doctor`, for anything that would keep this run from starting."""
    for seen in (machine.loopback(), machine.files(len(launch.groups(scenario.robots.number)))):
        if seen.status is Status.FAILED:
            raise FesError(f"{seen.check}: {seen.seen}; {seen.remedy}")


def run(launch: Launch, scenario: Scenario, directory: RunDirectory, console: Console) -> dict[str, Any]:
    """Run a scenario with one process for the world and one for each group of agents; returns the summary.

    Every child ends with this call, however it ends. Raises FesError if the world fails, or if an agent does before
    the run begins, and Stopped after a signal.
    """
    with contextlib.closing(Warnings(held=launch.dashboard)) as warnings:
        process.supervise(lambda: _run(launch, scenario, directory, console, warnings))
    summary = read_summary(directory.path)
    if summary["ticks"] < scenario.ticks:
        reached = f"{summary['ticks']} of {scenario.ticks} ticks"
        raise FesError(f"the world was stopped after {reached} (see {directory.path})")
    return summary


class Warnings:
    """Warnings during a run: printed at once, or `held` until no dashboard covers them."""

    def __init__(self, held: bool) -> None:
        self._held = held
        self._waiting: list[str] = []

    def add(self, line: str) -> None:
        """Print a line, or hold it."""
        if self._held:
            self._waiting.append(line)
        else:
            process.warn("fes", line)

    def close(self) -> None:
        """Print all lines that were held."""
        for line in self._waiting:
            process.warn("fes", line)


async def _run(
    launch: Launch, scenario: Scenario, directory: RunDirectory, console: Console, warnings: Warnings
) -> None:
    groups, path = launch.groups(scenario.robots.number), directory.path
    with keys_command.of_a_run(path, groups) if launch.secure else contextlib.nullcontext() as kept:
        with_keys = ["--keys", str(kept)] if kept else []
        endpoint = f"{'tls' if kept else 'tcp'}/127.0.0.1:{process_group.free_port()}"
        address = Address(endpoint, RUN, os.getpid(), str(kept) if kept else None)
        async with _family(directory) as family:
            flags = ["-l", endpoint, "--rtf", launch.rtf, *with_keys]
            world = [str(path / "scenario.toml"), "--name", launch.name, "--out", str(path)]
            resuming = ["--resume", str(path), *flags]
            await family.start_world([*world, *([] if launch.record else ["--no-record"]), *flags])
            run_directory.announce(path, address)
            try:
                joining = ["-e", endpoint, "--timeout", str(JOIN_TIMEOUT), *with_keys]
                # First, to be there when the run begins.
                async with _inject_faults(family, launch, scenario, address, resuming):
                    for ids in groups:
                        await family.start_agent(ids, joining)
                    again = RestartLimit() if launch.respawn else None
                    supervisor = Supervisor(family, warnings.add, _all_agents_ended(scenario, endpoint), again)
                    await _attend(supervisor, launch, address, console)
            finally:
                run_directory.withdraw(path)


@contextlib.asynccontextmanager
async def _family(directory: RunDirectory) -> AsyncIterator[ProcessGroup]:
    """The children of a run. A second signal waits for none of them. It lets a world that has begun close by itself,
    and leaves nothing of one that has not."""
    family = ProcessGroup(directory.path)

    def abandon() -> None:
        if family.has_begun:
            run_directory.withdraw(directory.path)
            closing = family.world is not None and family.world.runs  # else it is away: another was to resume the run
            end = f"the world closes {directory.path} by itself" if closing else f"see {directory.path}"
            process.complain("fes", f"stopped at once: {end}")
        else:
            family.abandon()
            directory.discard()

    with signals.if_forced(abandon):
        async with process_group.ended_with_block(family):
            yield family


@contextlib.asynccontextmanager
async def _inject_faults(
    family: ProcessGroup, launch: Launch, scenario: Scenario, address: Address, resuming: list[str]
) -> AsyncIterator[None]:
    """While the block lasts, processes die and hang as scheduled: the world's, and robots' if each has its own."""
    alone = launch.agents_per_process == 1
    if not (scenario.world_deaths or (alone and scenario.participation)):
        yield
        return

    async def follow() -> None:
        async with bus.opened(_visitor(address)) as opened:
            control = fault_injection.ProcessControl(
                family.kill_agent,
                family.start_agent_again,
                family.stop_agent,
                family.continue_agent,
                lambda seconds: family.replace_world(seconds, resuming),
            )
            await fault_injection.enact(opened, RUN, JOIN_TIMEOUT, scenario, control, alone)

    following = asyncio.ensure_future(follow())
    try:
        yield
    finally:
        following.cancel()
        with contextlib.suppress(asyncio.CancelledError, Exception):  # the world keeps the schedule without us
            await following


def _all_agents_ended(scenario: Scenario, endpoint: str) -> str:
    """Warning for a run of which no agent is left."""
    if scenario.run.clock == "live":
        return "no agent is left: all robots stand still until the end"
    return f"no agent is left: the world at {endpoint} waits {RETURN_TIMEOUT:g} s for one, and then ends"


def _visitor(address: Address) -> Endpoints:
    own = identity.security(Path(address.keys) if address.keys else None, identity.OBSERVER)
    return Endpoints("client", (address.endpoint,), timeout=JOIN_TIMEOUT, security=own)


def read_summary(directory: Path) -> dict[str, Any]:
    """The summary in a run directory; raises FesError, also for a file that is not a table."""
    try:
        found = strict_json.loads(files.read(directory / "summary.json", MAX_SUMMARY))
    except (OSError, ValueError):
        found = None
    if not isinstance(found, dict):
        raise FesError(f"{directory} has no summary")
    return found


async def _attend(supervisor: Supervisor, launch: Launch, address: Address, console: Console) -> None:
    """Wait for the children to end, and show the run meanwhile if a person looks."""
    if not is_screen(console):
        await supervisor.finish()
        return
    show = asyncio.ensure_future(_show(launch, address, console))
    try:
        await supervisor.finish()
    finally:
        show.cancel()
        with contextlib.suppress(asyncio.CancelledError, Exception):  # what fails in a view is not the run's
            await show


async def _show(launch: Launch, address: Address, console: Console) -> None:
    """The dashboard, or a line of progress; a view only, whose failure is not the run's."""

    async with bus.opened(_visitor(address)) as opened:
        if launch.dashboard:
            with live.Screen(console, BELOW) as screen:
                await live.watch(opened, RUN, JOIN_TIMEOUT, screen)
            return
        with progress.status(console, "waiting for the robots") as shown:
            async for report in observer.reports(opened, RUN, JOIN_TIMEOUT, live.IDLE):
                if report is not None:
                    shown.name(
                        f"tick {report.tick} of {report.ticks}, {report.ticks_per_s:.0f} ticks/s, "
                        f"largest separation error {report.separation_error_max:.3f} m"
                    )
