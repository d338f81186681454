"""fes set: change the channel of a running run."""

import math
from typing import Annotated

import typer

from console.connect import run_directory
from console.connect.options import Cfg, Config, Connect, OperatorKeys, Run
from console.connect.run_directory import Client
from console.terminal import printing, progress
from fes import command_line, process
from fes.errors import Unavailable
from fes.protocol import channel_change, keys
from fes.protocol.channel_change import ParameterChange
from fes.system import strict_json
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
    changes = [channel_change.encode_change(ParameterChange(*parse_override(text))) for text in settings]
    endpoints = run_directory.endpoints(Client(OPERATOR, certificates, run, timeout), connect, config, cfg)

    async def send() -> int:
        async with bus.opened(endpoints) as session:
            for change in changes:
                try:
                    with progress.waiting("waiting for the world's answer"):
                        answer = await session.get(keys.change(run), change, timeout)
                except Unavailable:
                    raise Unavailable(f"no world of run '{run}' answers at {endpoints.shown}") from None
                result = channel_change.decode_result(answer)
                optimal = result.optimal_separation
                printing.line(
                    f"{result.path} = {strict_json.dumps(result.value)} from tick {result.tick} on; "
                    + (f"r* = {optimal:.3f} m" if math.isfinite(optimal) else "it has no r*")
                )
            if result.unnoticed:  # of the last change, since it describes the present channel
                printing.line(remarks.UNNOTICED)
        return process.SUCCESS

    process.leave("fes", send, needs_its_end=True)
