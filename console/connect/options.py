"""Arguments and flags that several commands share; the table of `fes.transport.network_flags`, for Typer."""

from pathlib import Path
from typing import Annotated, Any

import typer

from fes.extension import registry
from fes.transport import network_flags
from fes.transport.identity import OBSERVER, OPERATOR, WORLD
from fes.transport.network_flags import NetworkFlag
from world.config import builtin


def _use(modules: list[str] | None) -> list[str] | None:
    for module in modules or ():
        registry.use(module)
    return modules


Use = Annotated[
    list[str] | None,
    typer.Option(
        "--use",
        metavar="MODULE",
        callback=_use,
        help="Import a module or a file, and allow its extensions; may be repeated.",
    ),
]
SET = "Override a field of the scenario; fes schema lists them."
PACE = "Pace: simulated seconds per second, or max for full speed."
VERBOSE = "Also print tracking, links, their beacons and all expectations."


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def _option(flag: NetworkFlag) -> Any:
    """A flag of the network, for Typer; its help names the default."""
    return typer.Option(*flag.names, metavar=flag.metavar, help=_sentence(flag.help), show_default=False)


def _keys(role: str) -> Any:
    text = f"use TLS, with the certificate of the {role} in this folder (fes keys init)"
    return _option(network_flags.KEYS._replace(help=text))


Scenario = Annotated[
    Path,
    typer.Argument(metavar="SCENARIO", help=_sentence(builtin.ARGUMENT), autocompletion=builtin.completions),
]

Connect = Annotated[list[str] | None, _option(network_flags.CONNECT)]
Listen = Annotated[list[str] | None, _option(network_flags.LISTEN)]
Config = Annotated[Path | None, _option(network_flags.CONFIG)]
Cfg = Annotated[list[str] | None, _option(network_flags.CFG)]
Run = Annotated[str, _option(network_flags.RUN)]

ObserverKeys = Annotated[Path | None, _keys(OBSERVER)]
KEYS: dict[str, Any] = {OBSERVER: ObserverKeys, OPERATOR: Annotated[Path | None, _keys(OPERATOR)]}
"""The flag --keys by the role of the certificate."""
WorldKeys = Annotated[Path | None, _keys(WORLD)]
