"""fes view: the dashboard of a running run."""

import contextlib
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from console.connect import index_source
from console.connect.reach import Reach, reaching
from console.dashboard import live
from console.foxglove import server
from console.terminal import printing
from console.web import command as page
from console.web.command import Operator, Web
from fes import command_line, process
from fes.errors import FesError, Unavailable
from fes.protocol import keys
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from fes.transport.identity import OBSERVER, OPERATOR

LOOK = 2.0
"""Longest time to look for the tokens of a run [s]."""

Picture = Annotated[Path | None, typer.Option(help="Write the last frame to this SVG file.")]


@reaching(OBSERVER)
def view(
    reach: Reach,
    picture: Picture = None,
    web: Web = False,
    operator: Operator = False,
    foxglove: Annotated[
        bool, typer.Option("--foxglove", help="Serve the run to Foxglove and Lichtblick, instead of a dashboard.")
    ] = False,
    port: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=65535,
            help=f"Port of --web (default {page.PORT}) or --foxglove (default {server.PORT}); 0 for a free one.",
        ),
    ] = None,
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=command_line.YEAR, help="Longest wait for the world [s].")
    ] = 30.0,
) -> int:
    """Show the dashboard of a running run (by default the latest one started in this folder)."""
    if web + foxglove + (picture is not None) > 1:
        raise FesError("choose one of --web, --foxglove and --picture")
    if operator and not web:
        raise FesError("--operator goes with --web")
    if web:
        _serve_page(reach, timeout, page.PORT if port is None else port, operator)
    if foxglove:
        session = opened(reach.endpoints(timeout), reach.run)
        number = server.PORT if port is None else port
        process.leave("fes", lambda: server.serve(session, reach.run, timeout, number))
    if port is not None:
        raise FesError("--port is that of --web or --foxglove")
    screen = printing.console()

    async def show(session: Bus) -> int:
        await refuse_real_robots(session, reach.run)
        shown = live.Screen(screen, source=index_source.of_running(reach.run, reach.endpoints(timeout)))
        with shown as frames, live.saved(frames, picture, "fes view"):
            await live.watch(session, reach.run, timeout, frames)
        return process.SUCCESS

    reach.leave(timeout, show)


def _serve_page(reach: Reach, timeout: float, port: int, operator: bool) -> NoReturn:
    """Serve the page of a run, with controls for an operator."""
    page.require()
    reach = replace(reach, role=OPERATOR if operator else OBSERVER)
    endpoints = reach.endpoints(timeout)
    may_change = operator or page.may_change(endpoints)

    async def serve(session: Bus) -> int:
        await refuse_real_robots(session, reach.run)
        about = page.facts_of(reach.run, endpoints)
        await page.watch(session, reach.run, timeout, port, about, may_change)
        return process.SUCCESS

    reach.leave(timeout, serve)


@contextlib.asynccontextmanager
async def opened(endpoints: Endpoints, run: str) -> AsyncIterator[Bus]:
    """A session with the router of a run of a world; raises Unavailable."""
    async with bus.opened(endpoints) as session:
        await refuse_real_robots(session, run)
        yield session


async def refuse_real_robots(session: Bus, run: str) -> None:
    """Raise Unavailable if a run has gates of real robots and no world, which `fes view` would await in vain."""
    try:
        worlds = await session.liveliness_get(keys.world_alive(run), LOOK)
        gates = await session.liveliness_get(keys.gate_alive(run, "*"), LOOK)
    except Unavailable:
        return  # the router does not answer: the wait for the world will tell
    if gates and not worlds:
        raise Unavailable(f"run '{run}' has real robots and no world: fes team view shows them")
