"""Flags that several commands share: how to reach a run."""

from pathlib import Path
from typing import Annotated

import typer

SET = "Override a field of the scenario; fes schema lists them."
VERBOSE = "Print the tracking, the links, their beacons and all expectations too."

Connect = Annotated[
    list[str] | None, typer.Option("--connect", "-e", metavar="ENDPOINT", help="Where the world listens.")
]
Config = Annotated[Path | None, typer.Option("--config", "-c", help="Zenoh configuration file.")]
Cfg = Annotated[list[str] | None, typer.Option(metavar="KEY:VALUE", help="Zenoh setting.")]

ObserverKeys = Annotated[
    Path | None, typer.Option("--keys", metavar="DIR", help="TLS, with the certificate of the observer in DIR.")
]
OperatorKeys = Annotated[
    Path | None, typer.Option("--keys", metavar="DIR", help="TLS, with the certificate of the operator in DIR.")
]
