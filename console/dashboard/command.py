"""fes view: the dashboard of a running run."""

from pathlib import Path
from typing import Annotated

import typer

from console.connect.reach import Reach, reaching
from console.dashboard import live
from console.terminal import printing
from fes import command_line, process
from fes.errors import Unavailable
from fes.protocol import keys
from fes.transport.bus import Bus
from fes.transport.identity import OBSERVER

LOOK = 2.0
"""Longest time to look for the tokens of a run [s]."""

Picture = Annotated[Path | None, typer.Option(help="Write the last frame to this SVG file.")]


@reaching(OBSERVER)
def view(
    reach: Reach,
    picture: Picture = None,
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=command_line.YEAR, help="Longest wait for the world [s].")
    ] = 30.0,
) -> int:
    """Show the dashboard of a running run (by default the latest one started in this folder)."""
    screen = printing.console()

    async def show(session: Bus) -> int:
        await refuse_real_robots(session, reach.run)
        with live.Screen(screen) as frames, live.saved(frames, picture, "fes view"):
            await live.watch(session, reach.run, timeout, frames)
        return process.SUCCESS

    reach.leave(timeout, show)


async def refuse_real_robots(session: Bus, run: str) -> None:
    """Raise Unavailable if a run has gates of real robots and no world, which `fes view` would await in vain."""
    try:
        worlds = await session.liveliness_get(keys.world_alive(run), LOOK)
        gates = await session.liveliness_get(keys.gate_alive(run, "*"), LOOK)
    except Unavailable:
        return  # the router does not answer: the wait for the world will tell
    if gates and not worlds:
        raise Unavailable(f"run '{run}' has real robots and no world: fes team view shows them")
