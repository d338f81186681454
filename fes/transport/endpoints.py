"""Endpoints of a process, and the settings of its Zenoh session."""

import ipaddress
import logging
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from fes.errors import FesError
from fes.protocol.wire import MAX_PAYLOAD
from fes.system import encoding
from fes.transport import addresses

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
SECURE_ENDPOINT = "tls/127.0.0.1:7447"

MAX_MESSAGE = MAX_PAYLOAD
"""Longest message [bytes]; the transport drops longer ones."""

_OPEN = re.compile(r"(tcp|udp|ws)/(?P<host>\S+):\d{1,5}")
"""An endpoint without encryption and authentication."""

Mode = Literal["router", "client", "peer"]


@dataclass(frozen=True)
class Endpoints:
    """Endpoints and mode of a process; Zenoh's own flags."""

    mode: Mode
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
    config_file: Path | None = None
    settings: tuple[str, ...] = ()
    """KEY:VALUE pairs, the value in JSON5."""
    timeout: float = 10.0
    """Timeout of the connection [s]."""
    by_default: frozenset[str] = frozenset()
    """Default settings: those of the configuration file override them."""
    security: Mapping[str, object] = field(default_factory=dict)
    """Settings by Zenoh's key: the certificates of this process, and the roles that it accepts."""

    @property
    def shown(self) -> str:
        """The endpoints as messages show them."""
        return ", ".join(self.connect or self.listen) or "no endpoint"

    def __post_init__(self) -> None:
        for endpoint in (*self.connect, *self.listen):
            addresses.check(endpoint, listening=endpoint in self.listen)
            if self.security and not endpoint.startswith("tls/"):
                raise FesError(f"--keys needs an endpoint like {SECURE_ENDPOINT}: {endpoint}")

    def house_rules(self) -> dict[str, object]:
        """The settings, by Zenoh's key, on which the lockstep relies."""
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
            # Shared memory bypasses the size limit below, and may drop messages silently.
            "transport/shared_memory/enabled": False,
            "transport/link/tx/lease": 2000,
            # By default one put waits 5 s for a cut link; a far shorter wait lets a flood close links of slow robots.
            "transport/link/tx/queue/congestion_control/block/wait_before_close": 2_000_000,
            "transport/link/rx/max_message_size": MAX_MESSAGE,
            "transport/unicast/open_timeout": 2000,
            "transport/unicast/accept_timeout": 2000,
            **self.security,
        }

    def own_settings(self) -> list[tuple[str, str]]:
        """The settings of --cfg, as key and JSON5 value; raises FesError for one without a colon."""
        pairs = [encoding.argument(setting).partition(":") for setting in self.settings]
        for key, colon, _ in pairs:
            if not colon:
                raise FesError(f"--cfg expects KEY:VALUE, got '{key}'")
        return [(key, text) for key, _, text in pairs]


def default_endpoint(*, secure: bool) -> str:
    """The default endpoint of a world."""
    return SECURE_ENDPOINT if secure else DEFAULT_ENDPOINT


def exposed(endpoint: str) -> bool:
    """True if any machine of the network can connect to a process that listens there; TLS demands a certificate.

    >>> exposed("tcp/127.0.0.1:7447"), exposed("tcp/0.0.0.0:7447"), exposed("tls/0.0.0.0:7447")
    (False, True, False)
    """
    match = _OPEN.match(endpoint)
    if match is None:
        return False
    host = match["host"].strip("[]")
    try:
        return not ipaddress.ip_address(host.partition("%")[0]).is_loopback
    except ValueError:
        return host != "localhost"


def warn_if_exposed(listening: str) -> None:
    """Warn of each endpoint in `listening`, Zenoh's setting in JSON, that is exposed."""
    for endpoint in re.findall(r'"([a-z]+/[^"]+)"', listening):
        if exposed(endpoint):
            logging.getLogger("network").warning(
                "listening on %s without TLS: any process that reaches it can steer robots; "
                "--keys DIR requires certificates",
                endpoint,
            )
