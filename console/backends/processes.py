"""fes run with processes: one world, its agents, and a dashboard."""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from console.backends import fault_injection, process_group
from console.backends.process_group import ProcessGroup
from console.backends.restart_limits import RestartLimit
from console.backends.supervisor import Supervisor
from console.backends.view import RUN, View
from console.connect import run_directory
from console.connect.run_directory import Address, RunDirectory
from console.doctor import machine
from console.doctor.finding import Status
from console.keys import command as keys_command
from fes import process
from fes.errors import FesError
from fes.system import files, signals, strict_json
from fes.transport import bus, identity
from fes.transport.endpoints import Endpoints
from world.config.outside import extensions
from world.config.scenario import Scenario
from world.server.lockstep import RETURN_TIMEOUT

MAX_SUMMARY = 1 << 30
"""Largest summary that is read [bytes]; a hundred robots take 100 kB."""

JOIN_TIMEOUT = 60.0
"""Longest time for which a child looks for the world [s]; a loaded machine starts ten interpreters slowly."""


Supervise = Callable[[Callable[[], Coroutine[None, None, None]]], None]
"""Runs a coroutine function to its end; on a signal it cancels the coroutine and raises Stopped."""


@dataclass(frozen=True)
class Launch:
    """Settings of a run, in addition to its scenario."""

    name: str
    """Name of the scenario."""
    agents_per_process: int
    rtf: str
    dashboard: bool
    record: bool
    secure: bool = False
    """True for TLS, with certificates made for this run."""
    respawn: bool = False
    """True if agents that die are restarted."""

    def groups(self, robots: int) -> list[str]:
        """The robot ids of each agent process."""
        return list(share(robots, self.agents_per_process))


def share(robots: int, per_process: int) -> Iterator[str]:
    """Robot ids of each agent process, with up to `per_process` robots.

    >>> list(share(5, 2))
    ['0-1', '2-3', '4']
    """
    for first in range(0, robots, per_process):
        last = min(first + per_process, robots) - 1
        yield str(first) if first == last else f"{first}-{last}"


def check(launch: Launch, scenario: Scenario) -> None:
    """Raise FesError, in the words of `fes doctor`, if this machine cannot start the run."""
    extensions.check_importable(scenario)
    for finding in (machine.loopback(), machine.files(len(launch.groups(scenario.robots.number)))):
        if finding.status is Status.FAILED:
            raise FesError(f"{finding.check}: {finding.seen}; {finding.remedy}")


def run(
    launch: Launch,
    scenario: Scenario,
    directory: RunDirectory,
    view: View | None = None,
    supervise: Supervise = process.supervise,
) -> dict[str, Any]:
    """Run a scenario with one process for the world and one for each group of agents; returns the summary.

    `view` is started with the run, and cancelled when the run is over. Every child ends with this call, also after an
    error. Raises FesError if the world fails, or if an agent does before the run begins, and Stopped after a signal.
    """
    with contextlib.closing(Warnings(held=launch.dashboard)) as warnings:
        supervise(lambda: _run(launch, scenario, directory, view, warnings))
    summary = read_summary(directory.path)
    if summary["ticks"] < scenario.ticks:
        reached = f"{summary['ticks']} of {scenario.ticks} ticks"
        raise FesError(f"the world was stopped after {reached} (see {directory.path})")
    return summary


class Warnings:
    """Warnings during a run: printed at once, or `held` until the dashboard has closed."""

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
        """Print the held lines."""
        for line in self._waiting:
            process.warn("fes", line)


async def _run(
    launch: Launch, scenario: Scenario, directory: RunDirectory, view: View | None, warnings: Warnings
) -> None:
    groups, path = launch.groups(scenario.robots.number), directory.path
    with keys_command.for_run(path, groups) if launch.secure else contextlib.nullcontext() as folder:
        with_keys = ["--keys", str(folder)] if folder else []
        endpoint = f"{'tls' if folder else 'tcp'}/127.0.0.1:{process_group.free_port()}"
        address = Address(endpoint, RUN, os.getpid(), str(folder) if folder else None)
        async with _processes(directory) as group:
            flags = ["-l", endpoint, "--rtf", launch.rtf, *with_keys]
            world = [str(path / "scenario.toml"), "--name", launch.name, "--out", str(path)]
            resuming = ["--resume", str(path), *flags]
            await group.start_world([*world, *([] if launch.record else ["--no-record"]), *flags])
            run_directory.announce(path, address)
            try:
                joining = ["-e", endpoint, "--timeout", str(JOIN_TIMEOUT), *with_keys]
                # before the agents, so that it is connected when the run begins
                async with _inject_faults(group, launch, scenario, address, resuming):
                    for ids in groups:
                        await group.start_agent(ids, joining)
                    limit = RestartLimit() if launch.respawn else None
                    supervisor = Supervisor(group, warnings.add, _all_agents_ended(scenario, endpoint), limit)
                    await _attend(supervisor, view, address)
            finally:
                run_directory.withdraw(path)


@contextlib.asynccontextmanager
async def _processes(directory: RunDirectory) -> AsyncIterator[ProcessGroup]:
    """The processes of a run, until the block ends.

    After a second signal no process is awaited. The world of a run that has begun then closes the run by itself. A
    run that has not begun leaves no file behind.
    """
    group = ProcessGroup(directory.path)

    def abandon() -> None:
        if group.has_begun:
            run_directory.withdraw(directory.path)
            closing = group.world is not None and group.world.runs
            end = f"the world closes {directory.path} by itself" if closing else f"see {directory.path}"
            process.complain("fes", f"stopped at once: {end}")
        else:
            group.abandon()
            directory.discard()

    with signals.if_forced(abandon):
        async with process_group.ended_with_block(group):
            yield group


@contextlib.asynccontextmanager
async def _inject_faults(
    group: ProcessGroup, launch: Launch, scenario: Scenario, address: Address, resuming: list[str]
) -> AsyncIterator[None]:
    """A block during which processes of the world, and of robots with one each, die and hang by schedule."""
    alone = launch.agents_per_process == 1
    if not (scenario.world_deaths or (alone and scenario.participation)):
        yield
        return

    async def follow() -> None:
        async with bus.opened(_observer(address)) as session:
            control = fault_injection.ProcessControl(
                group.kill_agent,
                group.start_agent_again,
                group.stop_agent,
                group.continue_agent,
                lambda seconds: group.replace_world(seconds, resuming),
            )
            await fault_injection.enact(session, RUN, JOIN_TIMEOUT, scenario, control, alone)

    following = asyncio.ensure_future(follow())
    try:
        yield
    finally:
        following.cancel()
        # The world keeps the schedule even if these faults fail.
        with contextlib.suppress(asyncio.CancelledError, Exception):
            await following


def _all_agents_ended(scenario: Scenario, endpoint: str) -> str:
    """Warning for a run whose agents have all ended."""
    if scenario.run.clock == "live":
        return "no agent is left: all robots stand still until the end"
    return f"no agent is left: the world at {endpoint} waits {RETURN_TIMEOUT:g} s for one, and then ends"


def _observer(address: Address) -> Endpoints:
    """Endpoints of an observer of the run."""
    own = identity.security(Path(address.keys) if address.keys else None, identity.OBSERVER)
    return Endpoints("client", (address.endpoint,), timeout=JOIN_TIMEOUT, security=own)


def read_summary(directory: Path) -> dict[str, Any]:
    """The summary in a run directory; raises FesError, also for a file that is not a table."""
    try:
        summary = strict_json.loads(files.read(directory / "summary.json", MAX_SUMMARY))
    except (OSError, ValueError):
        summary = None
    if not isinstance(summary, dict):
        raise FesError(f"{directory} has no summary")
    return summary


async def _attend(supervisor: Supervisor, view: View | None, address: Address) -> None:
    """Wait for the end of the children, with a view of the run in the meantime."""
    if view is None:
        await supervisor.finish()
        return
    show = asyncio.ensure_future(view(_observer(address)))
    try:
        await supervisor.finish()
    finally:
        show.cancel()
        with contextlib.suppress(asyncio.CancelledError, Exception):  # an error of the view does not concern the run
            await show
