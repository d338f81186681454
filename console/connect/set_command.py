"""fes set: change the channel of a running run."""

from typing import Annotated

import typer

from console.connect import channel_request, run_directory
from console.connect.options import Cfg, Config, Connect, OperatorKeys, Run
from console.connect.run_directory import Client
from console.terminal import printing, progress
from fes import command_line, process
from fes.errors import Unavailable
from fes.protocol import channel_change, keys
from fes.protocol.channel_change import ParameterChange
from fes.transport import bus
from fes.transport.identity import OPERATOR
from world.config import remarks
from world.config.scenario import parse_override


def set_command(
    settings: Annotated[
        list[str],
        typer.Argument(
            metavar="A.B=C...", help="Fields of the channel and their values, such as channel.reference_snr=5e6."
        ),
    ],
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: OperatorKeys = None,
    run: Run = keys.DEFAULT_RUN,
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=command_line.YEAR, help="Longest wait for the world's answer [s].")
    ] = 5.0,
) -> int:
    """Change the channel of a running run (by default the latest one started in this folder)."""
    changes = [ParameterChange(*parse_override(text)) for text in settings]
    for change in changes:
        channel_change.encode_change(change)  # reject a value that JSON cannot hold before the first request
    endpoints = run_directory.endpoints(Client(OPERATOR, certificates, run, timeout), connect, config, cfg)

    async def send() -> int:
        async with bus.opened(endpoints) as session:
            for change in changes:
                try:
                    with progress.waiting("waiting for the world's answer"):
                        result = await channel_request.send(session, run, change, timeout)
                except Unavailable as error:
                    raise Unavailable(f"{error} at {endpoints.shown}") from None
                printing.line(channel_request.described(result))
            if result.unnoticed:  # of the last change, since it describes the present channel
                printing.line(remarks.UNNOTICED)
        return process.SUCCESS

    process.leave("fes", send, needs_its_end=True)
