"""The flags that world and agents share, and what they say."""

import argparse
from collections.abc import Mapping
from typing import Any, NoReturn

from fes import process
from fes.extension import registry
from fes.protocol import keys
from fes.transport import identity, network_flags
from fes.transport.endpoints import Endpoints, Mode, default_endpoint

YEAR = 3.2e7  # s

SLOWEST = 1e-6
"""Smallest real-time factor [simulated seconds per second]: a program can still sleep for a tick of it."""


def seconds(text: str) -> float:
    """The argument of --timeout: a positive time [s], at most a year; raises ArgumentTypeError."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value <= YEAR:
        raise argparse.ArgumentTypeError(f"expects a positive time in seconds, got '{text}'")
    return value


def period(text: str) -> float:
    """The argument of --checkpoint: a time [s] from 0 to a year; raises ArgumentTypeError."""
    return 0.0 if text == "0" else seconds(text)


def real_time_factor(text: str) -> float | None:
    """The argument of --rtf: at least SLOWEST, or `max` for full speed (None); raises ArgumentTypeError."""
    if text == "max":
        return None
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not SLOWEST <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"expects 'max' or a number that is at least {SLOWEST:g}, got '{text}'")
    return value


class OneLineParser(argparse.ArgumentParser):
    """A parser that reports a bad argument in one line with exit code 1, as every other error."""

    def error(self, message: str) -> NoReturn:
        """Print the error, and end the process."""
        process.complain(self.prog, message)
        raise SystemExit(process.FAILURE)


def add_network_flags(parser: argparse.ArgumentParser) -> None:
    """Zenoh's own flags, as in its examples, and the run's name."""
    group = parser.add_argument_group("network")
    group.add_argument("-m", "--mode", choices=["router", "client", "peer"], help="Zenoh session mode")
    for flag in network_flags.ALL:
        group.add_argument(*flag.names, **flag.keywords)
    parser.set_defaults(run=keys.DEFAULT_RUN)
    parser.add_argument("--exit-with-stdin", action="store_true", help="stop when standard input ends")


def add_use_flag(parser: argparse.ArgumentParser) -> None:
    """Add the flag that allows modules of extensions."""
    parser.add_argument(
        "--use",
        action=_Use,
        default=[],
        metavar="MODULE",
        help="import a module or a file, and allow its extensions; may be repeated",
    )


def world_endpoints(flags: argparse.Namespace, access: Mapping[str, object] | None = None) -> Endpoints:
    """Endpoints of a world: a router that listens, unless the flags or the configuration file say otherwise.

    With `--keys` it speaks TLS only, to the roles that `access` names; raises FesError for an invalid certificate.
    """
    mode: Mode = flags.mode or "router"
    listen = tuple(flags.listen) or ((default_endpoint(secure=flags.keys is not None),) if mode == "router" else ())
    own = identity.security(flags.keys, identity.WORLD)
    return Endpoints(
        mode,
        tuple(flags.connect),
        listen,
        flags.config,
        tuple(flags.cfg),
        by_default=_without_flag(flags.connect, flags.listen),
        security={**own, **(access or {})} if own and mode != "client" else own,  # a client accepts no connections
    )


def agent_endpoints(flags: argparse.Namespace, timeout: float, role: str) -> Endpoints:
    """Endpoints of an agent: a client of the world's router, unless flags or configuration file say otherwise.

    With `--keys` it speaks TLS only, with the certificate of its role; raises FesError if that is invalid.
    """
    connect = tuple(flags.connect) or (default_endpoint(secure=flags.keys is not None),)
    return Endpoints(
        flags.mode or "client",
        connect,
        tuple(flags.listen),
        flags.config,
        tuple(flags.cfg),
        timeout,
        _without_flag(flags.connect, flags.listen),
        identity.security(flags.keys, role),
    )


def _without_flag(connect: list[str], listen: list[str]) -> frozenset[str]:
    """The endpoint settings for which no flag was given."""
    given = {"connect/endpoints": connect, "listen/endpoints": listen}
    return frozenset(key for key, endpoints in given.items() if not endpoints)


class _Use(argparse.Action):
    """Imports a module at once."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        registry.use(values)
