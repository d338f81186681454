"""fes view: the dashboard of a running run."""

import contextlib
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Annotated

import typer

from console.connect.reach import Reach, reaching
from console.dashboard import live, source
from console.foxglove import server
from console.terminal import printing
from fes import command_line, process
from fes.errors import FesError, Unavailable
from fes.protocol import keys
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from fes.transport.identity import OBSERVER

LOOK = 2.0
"""Longest time to look for the tokens of a run [s]."""

Picture = Annotated[Path | None, typer.Option(help="Write the last frame to this SVG file.")]


@reaching(OBSERVER)
def view(
    reach: Reach,
    picture: Picture = None,
    foxglove: Annotated[
        bool, typer.Option("--foxglove", help="Serve the topics of the log to Foxglove and Lichtblick instead.")
    ] = False,
    port: Annotated[
        int | None,
        typer.Option(
            min=0, max=65535, help=f"Port of --foxglove on {server.HOST} ({server.PORT} by default; 0: any free one)."
        ),
    ] = None,
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=command_line.YEAR, help="Longest wait for the world [s].")
    ] = 30.0,
) -> int:
    """Show the dashboard of a running run (by default the latest one started in this folder)."""
    if foxglove:
        if picture is not None:
            raise FesError("--picture is a frame of the terminal, which --foxglove does not draw")
        number = server.PORT if port is None else port
        session = opened(reach.endpoints(timeout), reach.run)
        process.leave("fes", lambda: server.serve(session, reach.run, timeout, number))
    if port is not None:
        raise FesError("--port is that of --foxglove")
    screen = printing.console()

    async def show(session: Bus) -> int:
        await refuse_real_robots(session, reach.run)
        shown = live.Screen(screen, source=source.of_running(reach.run, reach.endpoints(timeout)))
        with shown as frames, live.saved(frames, picture, "fes view"):
            await live.watch(session, reach.run, timeout, frames)
        return process.SUCCESS

    reach.leave(timeout, show)


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
