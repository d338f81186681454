"""Flags that say how a program reaches a run, in one table for both parsers of command lines.

The services fes-world and fes-agent use argparse, because importing Typer costs memory and time in every agent. The
command `fes` uses Typer. The services fes-robot and fes-tabletop use argparse too, with flags of their own.
"""

from pathlib import Path
from typing import Any, NamedTuple

from fes.protocol import keys


class NetworkFlag(NamedTuple):
    """A flag with its names and its help, as every program has them."""

    names: tuple[str, ...]
    metavar: str
    help: str
    is_repeatable: bool = False
    is_path: bool = False

    @property
    def keywords(self) -> dict[str, Any]:
        """Keyword arguments of argparse's `add_argument`."""
        if self.is_repeatable:
            return {"action": "append", "default": [], "metavar": self.metavar, "help": self.help}
        return {"type": Path if self.is_path else str, "metavar": self.metavar, "help": self.help}


CONNECT = NetworkFlag(("-e", "--connect"), "ENDPOINT", "endpoint to connect to, such as tcp/127.0.0.1:7447", True)
LISTEN = NetworkFlag(("-l", "--listen"), "ENDPOINT", "endpoint to listen on, such as tcp/127.0.0.1:7447", True)
CONFIG = NetworkFlag(("-c", "--config"), "FILE", "Zenoh configuration file", is_path=True)
CFG = NetworkFlag(("--cfg",), "KEY:VALUE", "Zenoh setting", True)
KEYS = NetworkFlag(("--keys",), "DIR", "use TLS, with the certificates in this folder (fes keys init)", is_path=True)
RUN = NetworkFlag(("--run",), "NAME", f"name of the run (default: {keys.DEFAULT_RUN})")

ALL = (CONNECT, LISTEN, CONFIG, CFG, KEYS, RUN)
"""In the order of the help."""
