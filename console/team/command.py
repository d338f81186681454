"""fes team: router, state, start, stop, permit and dashboard of a team of real robots."""

import asyncio
import contextlib
import math
import sys
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from console import guide
from console.connect import run_directory
from console.connect.options import Cfg, Config, Connect, Listen, ObserverKeys, OperatorKeys, Run, WorldKeys
from console.connect.run_directory import Client
from console.dashboard import live
from console.dashboard.command import Picture
from console.team import gates, observer, permit, router, status
from console.team.merge import Team
from console.team.recorder import TeamRecorder
from console.terminal import printing
from fes import command_line, process
from fes.protocol import keys
from fes.protocol.report import Report
from fes.system import strict_json
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from fes.transport.identity import OBSERVER, OPERATOR

CONNECTING = 5.0
"""Longest time to connect [s]."""

app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Watch, start and stop a team of real robots.",
)

Robots = Annotated[
    str | None,
    typer.Option(metavar="A-B", help="Robots, as I or A-B (default: all whose gate is alive).", show_default=False),
]
Seconds = Annotated[float, typer.Option("--for", min=0.0, max=command_line.YEAR, help="Longest time [s].")]


@guide.command(app, "team router")
def carry(
    listen: Listen = None,
    certificates: WorldKeys = None,
    run: Run = keys.DEFAULT_RUN,
    robots: Annotated[
        int, typer.Option(min=1, max=keys.MAX_ROBOTS, metavar="N", help="With --keys: robots 0 to N-1 may take part.")
    ] = 100,
) -> NoReturn:
    """Carry the team's network until Ctrl-C: gates, operators and observers connect to this router."""
    name = keys.check_run(run)
    process.run("fes", lambda: router.serve(name, tuple(listen or ()), certificates, robots))


@guide.command(app, "team status")
def show_status(
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: ObserverKeys = None,
    run: Run = keys.DEFAULT_RUN,
    robots: Robots = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the states as JSON, and nothing else.")] = False,
) -> int:
    """Print the state of each robot: gate, agent, pose, links and estimate."""

    async def show(session: Bus) -> int:
        states = await status.collect(session, run, await _chosen(session, run, robots))
        if json_:
            print(strict_json.dumps(status.tables(states), indent=2))
        else:
            printing.show(printing.console(), status.table(states))
        return process.SUCCESS

    endpoints = run_directory.endpoints(Client(OBSERVER, certificates, run, CONNECTING), connect, config, cfg)
    _leave(endpoints, show, needs_its_end=True)


@guide.command(app, "team start")
def start(
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: OperatorKeys = None,
    run: Run = keys.DEFAULT_RUN,
    robots: Robots = None,
    hold: Annotated[
        bool, typer.Option("--hold/--no-hold", help="Renew the permit until Ctrl-C, then stop the robots.")
    ] = True,
) -> int:
    """Start the robots and renew their permit until Ctrl-C; with --no-hold, fes team permit must renew it."""

    async def begin(session: Bus) -> int:
        chosen = await _chosen(session, run, robots)
        if hold:
            return _code(await permit.start_and_hold(session, run, chosen, _say))
        return _code(await permit.start(session, run, chosen, _say) == chosen)

    endpoints = run_directory.endpoints(Client(OPERATOR, certificates, run, CONNECTING), connect, config, cfg)
    _leave(endpoints, begin, needs_its_end=True)


@guide.command(app, "team stop")
def stop(
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: OperatorKeys = None,
    run: Run = keys.DEFAULT_RUN,
    robots: Robots = None,
    longest: Seconds = gates.STOPPING,
) -> int:
    """Stop the robots; the exit code is 1 unless each gate confirms it."""

    async def end(session: Bus) -> int:
        return _code(await permit.stop(session, run, await _chosen(session, run, robots), _say, longest))

    endpoints = run_directory.endpoints(Client(OPERATOR, certificates, run, CONNECTING), connect, config, cfg)
    _leave(endpoints, end, needs_its_end=True)


@guide.command(app, "team permit")
def hold_permit(
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: OperatorKeys = None,
    run: Run = keys.DEFAULT_RUN,
    longest: Seconds = math.inf,
) -> int:
    """Permit started robots to move until Ctrl-C, after which they stop within about a second."""

    async def hold(session: Bus) -> int:
        _say(f"run '{run}': the permit is renewed")
        try:
            await permit.publish(session, run, longest)
        finally:
            _say("the permit is no longer renewed: the gates stop their robots within about a second")
        return process.SUCCESS

    endpoints = run_directory.endpoints(Client(OPERATOR, certificates, run, CONNECTING), connect, config, cfg)
    _leave(endpoints, hold)


@guide.command(app, "team view")
def view(
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: ObserverKeys = None,
    run: Run = keys.DEFAULT_RUN,
    robots: Robots = None,
    picture: Picture = None,
    record: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write a log and a summary into this new directory.")
    ] = None,
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=command_line.YEAR, help="Longest wait for a robot [s].")
    ] = 30.0,
) -> int:
    """Show the dashboard of real robots, from their own reports."""
    team = Team(run, keys.parse_span(robots, "--robots") if robots else ())
    screen = printing.console()

    async def show(session: Bus) -> int:
        recording: AbstractContextManager[TeamRecorder | None]
        recording = contextlib.nullcontext() if record is None else TeamRecorder(record, team)
        with (
            recording as recorder,
            live.Screen(screen, expected="the robots") as frames,
            live.saved(frames, picture, "fes team view"),
        ):
            await live.follow(shown(observer.reports(session, run, timeout, team), team, frames, recorder), frames)
        return process.SUCCESS

    endpoints = run_directory.endpoints(Client(OBSERVER, certificates, run, timeout), connect, config, cfg)
    _leave(endpoints, show)


async def shown(
    reports: AsyncIterator[Report | None], team: Team, frames: live.Screen, recorder: TeamRecorder | None
) -> AsyncIterator[Report | None]:
    """The reports, after each was recorded and the modes of the gates were handed to the screen."""
    loop = asyncio.get_running_loop()
    async for report in reports:
        if report is not None:
            frames.history.modes = team.modes(loop.time())
            if recorder is not None:
                recorder.add(report)
        yield report


async def _chosen(session: Bus, run: str, robots: str | None) -> list[int]:
    """The robots that a person named, or else all whose gate is alive."""
    return list(keys.parse_span(robots, "--robots")) if robots else await gates.present(session, run)


def _leave(
    endpoints: Endpoints, main: Callable[[Bus], Coroutine[Any, Any, int]], *, needs_its_end: bool = False
) -> NoReturn:
    """Run `main` with an open session to its exit code, and end the process."""

    async def connected() -> int:
        async with bus.opened(endpoints) as session:
            return await main(session)

    process.leave("fes", connected, needs_its_end=needs_its_end)


def _code(is_complete: bool) -> int:
    return process.SUCCESS if is_complete else process.FAILURE


def _say(text: str) -> None:
    """Print one line at once, also into a pipe."""
    printing.line(text)
    sys.stdout.flush()
