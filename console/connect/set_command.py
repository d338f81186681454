"""fes set: change the channel of a running run."""

from typing import Annotated

import typer

from console.connect import channel_request
from console.connect.reach import Reach, reaching
from console.terminal import printing, progress
from fes import command_line, process
from fes.errors import Unavailable
from fes.protocol import channel_change
from fes.protocol.channel_change import ParameterChange
from fes.transport.bus import Bus
from fes.transport.identity import OPERATOR
from world.config import remarks
from world.config.scenario import parse_override


@reaching(OPERATOR)
def set_command(
    reach: Reach,
    settings: Annotated[
        list[str],
        typer.Argument(
            metavar="A.B=C...", help="Fields of the channel and their values, such as channel.reference_snr=5e6."
        ),
    ],
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=command_line.YEAR, help="Longest wait for the world's answer [s].")
    ] = 5.0,
) -> int:
    """Change the channel of a running run (by default the latest one started in this folder)."""
    changes = [ParameterChange(*parse_override(text)) for text in settings]
    for change in changes:
        channel_change.encode_change(change)  # reject a value that JSON cannot hold before the first request

    async def send(session: Bus) -> int:
        for change in changes:
            try:
                with progress.waiting("waiting for the world's answer"):
                    result = await channel_request.send(session, reach.run, change, timeout)
            except Unavailable as error:
                raise Unavailable(f"{error} at {reach.endpoints(timeout).shown}") from None
            printing.line(channel_request.described(result))
        if result.unnoticed:  # of the last change, since it describes the present channel
            printing.line(remarks.UNNOTICED)
        return process.SUCCESS

    reach.leave(timeout, send, needs_its_end=True)
