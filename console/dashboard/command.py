"""fes view: the dashboard of a running run."""

from pathlib import Path
from typing import Annotated

import typer

from console.connect import run_directory
from console.connect.options import Cfg, Config, Connect, ObserverKeys, Run
from console.connect.run_directory import Client
from console.dashboard import live
from console.terminal import printing
from console.web import command as page
from console.web.command import PORT, Operator, Port, Web
from fes import command_line, process
from fes.errors import Unavailable
from fes.protocol import keys
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.identity import OBSERVER, OPERATOR

LOOK = 2.0
"""Longest time to look for the tokens of a run [s]."""

Picture = Annotated[Path | None, typer.Option(help="Write the last frame to this SVG file.")]


def view(
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: ObserverKeys = None,
    run: Run = keys.DEFAULT_RUN,
    picture: Picture = None,
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=command_line.YEAR, help="Longest wait for the world [s].")
    ] = 30.0,
    web: Web = False,
    port: Port = PORT,
    operator: Operator = False,
) -> int:
    """Show the dashboard of a running run (by default the latest one started in this folder)."""
    if web:
        page.require()
    client = Client(OPERATOR if operator else OBSERVER, certificates, run, timeout)
    endpoints = run_directory.endpoints(client, connect, config, cfg)
    screen = printing.console()

    async def show() -> int:
        async with bus.opened(endpoints) as session:
            await refuse_real_robots(session, run)
            if web:
                about = page.facts_of(run, not connect)
                await page.watch(session, run, timeout, port, about, operator or page.may_change(endpoints))
            with live.Screen(screen) as frames, live.saved(frames, picture, "fes view"):
                await live.watch(session, run, timeout, frames)
        return process.SUCCESS

    process.leave("fes", show)


async def refuse_real_robots(session: Bus, run: str) -> None:
    """Raise Unavailable if a run has gates of real robots and no world, which `fes view` would await in vain."""
    try:
        worlds = await session.liveliness_get(keys.world_alive(run), LOOK)
        gates = await session.liveliness_get(keys.gate_alive(run, "*"), LOOK)
    except Unavailable:
        return  # the router does not answer: the wait for the world will tell
    if gates and not worlds:
        raise Unavailable(f"run '{run}' has real robots and no world: fes team view shows them")
