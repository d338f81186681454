"""fes set: change the channel of a run that goes on."""

from typing import Annotated

import typer

from console.connect import run_directory
from console.connect.options import Cfg, Config, Connect, OperatorKeys
from console.connect.run_directory import Visitor
from console.terminal import printing, progress
from fes import process
from fes.errors import Unavailable
from fes.protocol import channel_change, keys
from fes.protocol.channel_change import ParameterChange
from fes.system import strict_json
from fes.transport import bus
from fes.transport.identity import OPERATOR
from world.config import remarks
from world.config.scenario import parse_override


def set_command(
    what: Annotated[list[str], typer.Argument(metavar="A.B=C...", help="Such as channel.reference_snr=5e6.")],
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: OperatorKeys = None,
    run: Annotated[str, typer.Option(help="Name of the run.")] = keys.DEFAULT_RUN,
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=process.YEAR, help="Give up if no world answers by then [s].")
    ] = 5.0,
) -> int:
    """Change the channel of a run that goes on (by default the latest one started in this folder)."""
    changes = [channel_change.encode_change(ParameterChange(*parse_override(text))) for text in what]
    endpoints = run_directory.reach(Visitor(OPERATOR, certificates, run, timeout), connect, config, cfg)

    async def ask() -> int:
        async with bus.opened(endpoints) as opened:
            for one in changes:
                try:
                    with progress.waiting("waiting for the world's answer"):
                        answer = await opened.get(keys.change(run), one, timeout)
                except Unavailable:
                    raise Unavailable(f"no world of run '{run}' answers at {endpoints.shown}") from None
                effect = channel_change.decode_result(answer)
                printing.line(
                    f"{effect.path} = {strict_json.dumps(effect.value)} from tick {effect.tick} on; "
                    f"r* = {effect.optimal_separation:.3f} m"
                )
            if effect.unnoticed:  # of the last change: the channel as it is now
                printing.line(remarks.UNNOTICED)
        return process.SUCCESS

    process.leave("fes", ask, needs_its_end=True)
