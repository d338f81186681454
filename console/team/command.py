"""fes team: router, state, start, stop, permit and dashboard of a team of real robots."""

import asyncio
import contextlib
import math
import sys
from collections.abc import AsyncIterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from console import guide
from console.connect.options import Listen, Run, WorldKeys
from console.connect.reach import Reach, reaching
from console.dashboard import live
from console.dashboard.command import Picture
from console.team import gates, observer, permit, router, status
from console.team.merge import Team
from console.team.recorder import TeamRecorder
from console.terminal import printing, progress
from fes import command_line, process
from fes.protocol import keys
from fes.protocol.report import Report
from fes.system import strict_json
from fes.transport.bus import Bus
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


@guide.command(app, "team router")
def carry(
    listen: Listen = None,
    certificates: WorldKeys = None,
    run: Run = keys.DEFAULT_RUN,
    robots: Annotated[
        int, typer.Option(min=1, max=keys.MAX_ROBOTS, metavar="N", help="With --keys: robots 0 to N-1 may take part.")
    ] = 100,
) -> NoReturn:
    """Run the router of a team until Ctrl-C: gates, operators and observers connect to it."""
    name = keys.check_run(run)
    process.run("fes", lambda: router.serve(name, tuple(listen or ()), certificates, robots))


@guide.command(app, "team status")
@reaching(OBSERVER)
def show_status(
    reach: Reach,
    robots: Robots = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the states as JSON, and nothing else.")] = False,
) -> int:
    """Print the state of each robot: gate, agent, pose, links and estimate."""

    async def show(session: Bus) -> int:
        with progress.waiting("asking the gates and the robots"):
            states = await status.collect(session, reach.run, await _chosen(session, reach.run, robots))
        if json_:
            print(strict_json.dumps(status.tables(states), indent=2))
        else:
            printing.show(printing.console(), status.table(states))
        return process.SUCCESS

    reach.leave(CONNECTING, show, needs_its_end=True)


@guide.command(app, "team start")
@reaching(OPERATOR)
def start(
    reach: Reach,
    robots: Robots = None,
    hold: Annotated[
        bool, typer.Option("--hold/--no-hold", help="Renew the permit until Ctrl-C, then stop the robots.")
    ] = True,
) -> int:
    """Start the robots and renew their permit until Ctrl-C; with --no-hold, fes team permit must renew it."""

    async def begin(session: Bus) -> int:
        chosen = await _chosen(session, reach.run, robots)
        if hold:
            return _code(await permit.start_and_hold(session, reach.run, chosen, _say))
        return _code(await permit.start(session, reach.run, chosen, _say) == chosen)

    reach.leave(CONNECTING, begin, needs_its_end=True)


@guide.command(app, "team stop")
@reaching(OPERATOR)
def stop(
    reach: Reach,
    robots: Robots = None,
    longest: Annotated[
        float,
        typer.Option(
            "--for",
            min=0.0,
            max=command_line.YEAR,
            help="Time for which the stop is sent again to a gate that has not confirmed it [s].",
        ),
    ] = gates.STOPPING,
) -> int:
    """Stop the robots; the exit code is 1 unless each gate confirms it."""

    async def end(session: Bus) -> int:
        with progress.waiting("stopping the robots"):
            return _code(
                await permit.stop(session, reach.run, await _chosen(session, reach.run, robots), _say, longest)
            )

    reach.leave(CONNECTING, end, needs_its_end=True)


@guide.command(app, "team permit")
@reaching(OPERATOR)
def hold_permit(
    reach: Reach,
    longest: Annotated[
        float,
        typer.Option(
            "--for",
            min=0.0,
            max=command_line.YEAR,
            help="Time for which the permit is renewed [s] (default: until Ctrl-C).",
            show_default=False,
        ),
    ] = math.inf,
) -> int:
    """Permit started robots to move until Ctrl-C, after which they stop within about a second."""

    async def hold(session: Bus) -> int:
        _say(f"run '{reach.run}': the permit is renewed")
        try:
            await permit.publish(session, reach.run, longest)
        finally:
            _say("the permit is no longer renewed: the gates stop their robots within about a second")
        return process.SUCCESS

    reach.leave(CONNECTING, hold)


@guide.command(app, "team view")
@reaching(OBSERVER)
def view(
    reach: Reach,
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
    team = Team(reach.run, keys.parse_span(robots, "--robots") if robots else ())
    screen = printing.console()

    async def show(session: Bus) -> int:
        recording: AbstractContextManager[TeamRecorder | None]
        recording = contextlib.nullcontext() if record is None else TeamRecorder(record, team)
        with (
            recording as recorder,
            live.Screen(screen, expected="the robots") as frames,
            live.saved(frames, picture, "fes team view"),
        ):
            await live.follow(
                shown(observer.reports(session, reach.run, timeout, team), team, frames, recorder), frames
            )
        return process.SUCCESS

    reach.leave(timeout, show)


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


def _code(is_complete: bool) -> int:
    return process.SUCCESS if is_complete else process.FAILURE


def _say(text: str) -> None:
    """Print one line at once, also into a pipe."""
    printing.line(text)
    sys.stdout.flush()
