"""The command line of fes-tabletop."""

import argparse
import ipaddress
from pathlib import Path

from fes import command_line
from fes.transport.endpoints import DEFAULT_ENDPOINT
from world.config import builtin
from world.config.scenario import parse_override
from world.tabletop.radio.radio_socket import Place

RADIO = "127.0.0.1:7460"


def parser() -> command_line.OneLineParser:
    """The parser of all flags."""
    parser = command_line.OneLineParser(
        prog="fes-tabletop",
        description="Simulate small robots on a table: bodies, drivers, and a radio that loses beacons.",
        epilog="example: fes-tabletop tabletop --body mujoco",
    )
    parser.add_argument("scenario", metavar="SCENARIO", help=builtin.ARGUMENT)
    parser.add_argument("--body", choices=["kinematic", "mujoco"], help="override tabletop.body")
    parser.add_argument(
        "-l",
        "--listen",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help=f"endpoint of the router for drivers, gates and operator (default: {DEFAULT_ENDPOINT})",
    )
    parser.add_argument(
        "--radio",
        type=place,
        default=RADIO,
        metavar="HOST:PORT",
        help=f"address of the relay that forwards beacons (default: {RADIO})",
    )
    parser.add_argument(
        "--truth",
        type=Path,
        metavar="FILE",
        help="write true poses and counts of datagrams to this file",
    )
    parser.add_argument("--set", action="append", default=[], metavar="a.b=c", help="override a field")
    parser.add_argument("--seed", type=int, metavar="N", help="override run.seed")
    command_line.add_use_flag(parser)
    parser.add_argument("--exit-with-stdin", action="store_true", help="stop when standard input ends")
    return parser


def overrides(flags: argparse.Namespace) -> dict[str, object]:
    """The overrides in the flags, by dotted path."""
    values: dict[str, object] = dict(parse_override(text) for text in flags.set)
    if flags.seed is not None:
        values["run.seed"] = flags.seed
    if flags.body is not None:
        values["tabletop.body"] = flags.body
    return values


def place(text: str) -> Place:
    """The argument of --radio; raises ArgumentTypeError unless it is a port of this machine alone.

    >>> place("127.0.0.1:7460")
    ('127.0.0.1', 7460)
    """
    host, _, port = text.rpartition(":")
    try:
        is_own = ipaddress.IPv4Address(host).is_loopback
    except ValueError:
        is_own = False
    if not is_own or not (port.isascii() and port.isdigit() and len(port) <= 5 and int(port) <= 65535):
        raise argparse.ArgumentTypeError(f"expects a loopback address and a port like {RADIO}, got '{text}'")
    return host, int(port)
