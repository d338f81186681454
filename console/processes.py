"""fes run with real processes: one world, its agents, and whoever watches."""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from console import faults, keyring, launcher, observer, rundir, view
from console.launcher import Family
from console.rundir import Address
from fes import bus, files, identity, keys, process
from fes.endpoints import Endpoints
from fes.errors import FesError, Stopped
from world.scenario import Scenario

RUN = keys.DEFAULT_RUN
MAX_SUMMARY = 1 << 30
"""Size of a summary that is read [bytes]; that of a hundred robots has 100 kB."""

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


def run(launch: Launch, scenario: Scenario, directory: Path, console: Console) -> dict[str, Any]:
    """Run a scenario with one process for the world and one for each group of agents; returns the summary.

    Every child ends with this call, however it ends. Raises FesError if one of them fails, and Stopped after
    a signal; what was reached until then is in the directory.
    """
    try:
        process.supervise(lambda: _run(launch, scenario, directory, console))
    except Stopped as stopped:
        raise Stopped(f"{stopped}; what was reached is in {directory}") from None
    summary = read_summary(directory)
    if summary["ticks"] < scenario.ticks:
        raise FesError(f"the world was stopped after {summary['ticks']} of {scenario.ticks} ticks (see {directory})")
    return summary


async def _run(launch: Launch, scenario: Scenario, directory: Path, console: Console) -> None:
    groups = list(launcher.share(scenario.robots.number, launch.agents_per_process))
    with keyring.of_a_run(directory, groups) if launch.secure else contextlib.nullcontext() as kept:
        with_keys = ["--keys", str(kept)] if kept else []
        endpoint = f"{'tls' if kept else 'tcp'}/127.0.0.1:{launcher.free_port()}"
        address = Address(endpoint, RUN, os.getpid(), str(kept) if kept else None)
        async with launcher.family(directory) as family:
            flags = ["-l", endpoint, "--rtf", launch.rtf, *with_keys]
            world = [str(directory / "scenario.toml"), "--name", launch.name, "--out", str(directory)]
            resuming = ["--resume", str(directory), *flags]
            await family.start_world([*world, *([] if launch.record else ["--no-record"]), *flags])
            rundir.announce(directory, address)
            try:
                joining = ["-e", endpoint, "--timeout", str(JOIN_TIMEOUT), *with_keys]
                # First, to be there when the run begins.
                async with _faults(family, launch, scenario, address, joining, resuming):
                    for ids in groups:
                        await family.start_agent(ids, joining)
                    await _attend(family, launch, address, console)
            finally:
                rundir.withdraw(directory)


@contextlib.asynccontextmanager
async def _faults(
    family: Family, launch: Launch, scenario: Scenario, address: Address, joining: list[str], resuming: list[str]
) -> AsyncIterator[None]:
    """While the block lasts, processes die and hang as scheduled: the world's, and robots' if each has its own."""
    alone = launch.agents_per_process == 1
    if not (scenario.world_deaths or (alone and scenario.attendance)):
        yield
        return

    async def follow() -> None:
        async with bus.opened(_visitor(address)) as opened:
            hands = faults.Hands(
                family.kill_agent,
                lambda ids: family.start_agent(ids, joining),
                family.stop_agent,
                family.continue_agent,
                lambda seconds: family.replace_world(seconds, resuming),
            )
            await faults.enact(opened, RUN, JOIN_TIMEOUT, scenario, hands, alone)

    following = asyncio.ensure_future(follow())
    try:
        yield
    finally:
        following.cancel()
        with contextlib.suppress(asyncio.CancelledError, Exception):  # the world keeps the schedule without us
            await following


def _visitor(address: Address) -> Endpoints:
    own = identity.security(Path(address.keys) if address.keys else None, identity.OBSERVER)
    return Endpoints("client", (address.endpoint,), timeout=JOIN_TIMEOUT, security=own)


def read_summary(directory: Path) -> dict[str, Any]:
    """The summary in a run directory; raises FesError."""
    try:
        found = files.parse_json(files.read(directory / "summary.json", MAX_SUMMARY))
    except (OSError, ValueError):
        raise FesError(f"{directory} has no summary") from None
    return found if isinstance(found, dict) else {}


async def _attend(family: Family, launch: Launch, address: Address, console: Console) -> None:
    """Wait for the children to end, and show the run meanwhile if a person looks."""
    if not console.is_terminal:
        await family.finish()
        return
    show = asyncio.ensure_future(_show(launch, address, console))
    try:
        await family.finish()
    finally:
        show.cancel()
        with contextlib.suppress(asyncio.CancelledError, Exception):  # what fails in a view is not the run's
            await show


async def _show(launch: Launch, address: Address, console: Console) -> None:
    """The dashboard, or a line of progress; a view only, whose failure is not the run's."""
    async with bus.opened(_visitor(address)) as opened:
        if launch.dashboard:
            with view.Screen(console) as screen:
                await view.watch(opened, RUN, JOIN_TIMEOUT, screen)
            return
        with console.status("waiting for the robots") as status:
            async for report in observer.reports(opened, RUN, JOIN_TIMEOUT, view.IDLE):
                if report is not None:
                    status.update(
                        f"tick {report.tick} of {report.ticks}, {report.ticks_per_s:.0f} ticks/s, "
                        f"largest separation error {report.separation_error_max:.3f} m"
                    )
