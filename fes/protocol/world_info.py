"""About: a world's description of itself, on request. `fes doctor` asks for it; no run depends on it."""

import time
from importlib import metadata
from typing import NamedTuple

from fes.errors import FesError, MessageError
from fes.protocol import wire
from fes.system import distribution

LONGEST = 100
"""Longest version [characters]."""


class WorldInfo(NamedTuple):
    """A world, at the moment it was asked."""

    package: str
    """Version of fes."""
    zenoh: str
    """Version of eclipse-zenoh."""
    robots: int
    """Number of robots of the run."""
    clock: float
    """The world's clock [s since 1970, UTC]."""


def of_this_process(robots: int) -> WorldInfo:
    """The information about this process."""
    return WorldInfo(installed(distribution.NAME), installed("eclipse-zenoh"), robots, time.time())


def version() -> str:
    """Version of this project as it is installed, such as '0.2.0'; raises FesError if it is not installed."""
    if absence := distribution.absence():
        raise FesError(absence)
    return metadata.version(distribution.NAME)


def installed(package: str) -> str:
    """The installed version of a package, or `unknown`."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"


def encode_world_info(message: WorldInfo) -> bytes:
    """The payload of an About."""
    return wire.pack(*message)


def decode_world_info(payload: bytes) -> WorldInfo:
    """The About in a payload; raises MessageError, which names the other version if the protocol versions differ."""
    name = "About"
    package, zenoh, robots, clock = wire.unpack(name, payload, 4)
    for text in (package, zenoh):
        wire.check(name, type(text) is str and len(text) <= LONGEST and text.isprintable(), "expects a version", text)
    wire.check(name, type(robots) is int and 0 < robots <= wire.MAX_ID, "expects a number of robots", robots)
    wire.finite(name, (clock,))
    return WorldInfo(package, zenoh, robots, clock)


def speaks_otherwise(error: MessageError) -> bool:
    """True if a payload was rejected because it is of another protocol version."""
    return error.rule == wire.WRONG_VERSION
