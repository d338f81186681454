"""How a process takes part in the network: endpoints, and the settings of its Zenoh session."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from fes.errors import FesError
from fes.wire import MAX_PAYLOAD

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"

MAX_MESSAGE = MAX_PAYLOAD
"""Bytes; larger messages are dropped by the transport."""

_ENDPOINT = re.compile(r"(tcp|tls|udp|quic|ws)/\S+:\d{1,5}(\?\S*)?|(unixsock-stream|unixpipe|vsock|serial)/\S+")

Mode = Literal["router", "client", "peer"]


@dataclass(frozen=True)
class Endpoints:
    """How a process takes part in the network; Zenoh's own flags."""

    mode: Mode
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
    config_file: Path | None = None
    settings: tuple[str, ...] = ()
    """KEY:VALUE pairs, the value in JSON5."""
    timeout: float = 10.0
    """How long to try to connect [s]."""
    by_default: frozenset[str] = frozenset()
    """Settings that nobody asked for: where the configuration file has its own, that one holds."""

    @property
    def shown(self) -> str:
        """The endpoints as a person reads them."""
        return ", ".join(self.connect or self.listen) or "no endpoint"

    def __post_init__(self) -> None:
        for endpoint in (*self.connect, *self.listen):
            if not _ENDPOINT.fullmatch(endpoint):
                raise FesError(f"not an endpoint like {DEFAULT_ENDPOINT}: {endpoint}")

    def house_rules(self) -> dict[str, object]:
        """The session's settings, by Zenoh's key: the lockstep relies on them."""
        retry = {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5}
        return {
            "mode": self.mode,
            "listen/endpoints": list(self.listen),
            "connect/endpoints": list(self.connect),
            "scouting/multicast/enabled": False,
            "scouting/gossip/enabled": False,
            "scouting/delay": 0,
            "connect/timeout_ms": round(1000 * self.timeout),
            "connect/retry": retry,
            "listen/timeout_ms": 0,
            # Shared memory goes around the size limit below, and may drop without a word.
            "transport/shared_memory/enabled": False,
            "transport/link/tx/lease": 2000,
            # The default lets one put wait 5 s for a cut link; with much less a flood closes links of slow robots.
            "transport/link/tx/queue/congestion_control/block/wait_before_close": 2_000_000,
            "transport/link/rx/max_message_size": MAX_MESSAGE,
            "transport/unicast/open_timeout": 2000,
            "transport/unicast/accept_timeout": 2000,
        }

    def own_settings(self) -> list[tuple[str, str]]:
        """The person's settings, as key and JSON5 value; raises FesError for one without a colon."""
        pairs = [setting.partition(":") for setting in self.settings]
        for key, colon, _ in pairs:
            if not colon:
                raise FesError(f"--cfg expects KEY:VALUE, got '{key}'")
        return [(key, text) for key, _, text in pairs]


def why_not(endpoints: Endpoints, message: str) -> str:
    """Why a session could not be opened, in one line, from what Zenoh says."""
    if "in use" in message.lower():
        return f"cannot listen on {', '.join(endpoints.listen)}: the address is already in use"
    if endpoints.mode == "client":
        return f"nobody listens on {endpoints.shown} (tried for {endpoints.timeout:g} s)"
    return f"cannot open a session on {endpoints.shown}: {first_line(message)}"


def first_line(message: str) -> str:
    """The first line of an error of Zenoh, without the places in its source."""
    line = message.strip().splitlines()[0] if message.strip() else "unknown error"
    return re.sub(r" at /\S+:\d+\.?", "", line)
