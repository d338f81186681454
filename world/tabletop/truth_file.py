"""The truth, a line of JSON at a time, in a file: for tests and figures. No agent can read it over the network."""

from pathlib import Path
from typing import Any, TextIO

from fes.arrays.types import Floats
from fes.errors import FesError, reason
from fes.system import strict_json
from world.tabletop.radio.radio_socket import Place
from world.tabletop.radio.relay import Relay

PERIOD = 0.1
"""Time between two lines [s]."""


def line(time: float, monotonic: float, poses: Floats, twists: Floats, relay: Relay[Place] | None) -> str:
    """A line: time of the bodies and of this machine [s], poses [n, 3] at full size and twists [n, 2] on the table.

    `sent` and `forwarded` count the datagrams of each sender (row) for each receiver; empty without a relay.
    """
    values: dict[str, Any] = {
        "time": round(time, 6),
        "monotonic": monotonic,
        "poses": poses.tolist(),
        "twists": twists.tolist(),
        "sent": [] if relay is None else relay.sent.tolist(),
        "forwarded": [] if relay is None else relay.forwarded.tolist(),
    }
    return strict_json.dumps(values)


def create(path: Path) -> TextIO:
    """A new file; raises FesError where it cannot be written."""
    try:
        return path.open("w", encoding="utf-8", buffering=1)
    except OSError as error:
        raise FesError(f"--truth: {reason(error)}") from None
