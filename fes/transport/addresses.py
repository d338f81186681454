"""Addresses of endpoints: their rules, and the resolution of host names.

Zenoh reports the same error for an unresolved name, an impossible port, and an address where nothing listens. So the
text of an endpoint is checked before anything waits for it, and names are resolved apart from Zenoh.
"""

import ipaddress
import logging
import re
import socket
import threading
from typing import NamedTuple

from fes.errors import FesError, reason

EXAMPLE = "tcp/127.0.0.1:7447"

PATIENCE = 2.0
"""Longest wait for a name [s]: a name server that does not answer must not hold up the error that names it."""

MAX_PORT = 65535

_OVER_IP = ("tcp", "tls", "udp", "quic", "ws")
_OTHERS = ("unixsock-stream", "unixpipe", "vsock", "serial")
_ENDPOINT = re.compile(r"(?P<protocol>[^/?#]+)/(?P<address>[^?#]+)(\?[^#]*)?(#.*)?")
_ADDRESS = re.compile(r"(?P<host>.*):(?P<port>[^:\]]*)")
_LABEL = re.compile(r"[^.]{1,63}")
MAX_NAME = 253


class Place(NamedTuple):
    """Host and port of an endpoint."""

    host: str
    """Name or address; an IPv6 address without its brackets."""
    port: int


def check(endpoint: str, *, listening: bool) -> None:
    """Raise FesError, in one line, for an endpoint at which nothing can ever listen or be reached.

    Port 0 is an endpoint only where something is `listening`: there the system chooses a port.
    """
    match = _ENDPOINT.fullmatch(endpoint)
    if match is None or not endpoint.isprintable() or " " in endpoint:
        raise FesError(f"not an endpoint like {EXAMPLE}: {endpoint}")
    if match["protocol"] in _OTHERS:
        return
    if match["protocol"] not in _OVER_IP:
        raise FesError(f"the protocol of an endpoint is one of {', '.join(_OVER_IP + _OTHERS)}: {endpoint}")
    parts = _ADDRESS.fullmatch(match["address"])
    if parts is None or parts["port"] == "":
        raise FesError(f"an endpoint ends with its port, as {EXAMPLE} does: {endpoint}")
    port = parts["port"]
    if not (port.isascii() and port.isdigit() and len(port) <= 5 and int(port) <= MAX_PORT):
        raise FesError(f"a port is a number from 1 to {MAX_PORT}: {endpoint}")
    if int(port) == 0 and not listening:
        raise FesError(f"nothing can be reached at port 0: {endpoint}")
    _check_host(parts["host"], endpoint)


def _check_host(host: str, endpoint: str) -> None:
    if not host:
        raise FesError(f"an endpoint names a host before its port: {endpoint}")
    if host.startswith("[") and host.endswith("]"):
        try:
            ipaddress.IPv6Address(host[1:-1])
        except ValueError:
            raise FesError(f"only an IPv6 address stands in brackets: {endpoint}") from None
    elif ":" in host:
        protocol, _, rest = endpoint.partition("/")
        raise FesError(f"an IPv6 address needs brackets, {protocol}/[{host}]{rest[len(host) :]}: {endpoint}")
    elif len(host) > MAX_NAME or not all(map(_LABEL.fullmatch, host.removesuffix(".").split("."))):
        raise FesError(f"the name of a host is up to {MAX_NAME} letters, 1 to 63 between dots: {endpoint}")


def place(endpoint: str) -> Place | None:
    """Host and port of an endpoint that passed `check`; None if its protocol has neither.

    >>> place("tcp/[::1]:7447"), place("tls/lab.example:1?rel=1"), place("unixpipe/run/fes")
    (Place(host='::1', port=7447), Place(host='lab.example', port=1), None)
    """
    match = _ENDPOINT.fullmatch(endpoint)
    if match is None or match["protocol"] not in _OVER_IP:
        return None
    parts = _ADDRESS.fullmatch(match["address"])
    return Place(parts["host"].strip("[]"), int(parts["port"])) if parts else None


def unresolved(endpoint: str, patience: float = PATIENCE) -> str:
    """Reason why the host of an endpoint has no address, in a few words; empty if it has one, or needs none.

    The answer takes at most `patience` [s].
    """
    where = place(endpoint)
    if where is None or _is_literal(where.host):
        return ""
    results: list[str] = []

    def resolve() -> None:
        try:
            socket.getaddrinfo(where.host, where.port, type=socket.SOCK_STREAM)
            results.append("")
        except OSError as error:
            results.append(f"the name '{where.host}' does not resolve: {reason(error)}")
        except UnicodeError:
            results.append(f"'{where.host}' is not the name of a host")

    # In a daemon thread, since the system's resolver cannot be interrupted.
    thread = threading.Thread(target=resolve, name="resolve", daemon=True)
    thread.start()
    thread.join(patience)
    silent = f"the name '{where.host}' does not resolve: no name server answers within {patience:g} s"
    return results[0] if results else silent


def warn_of_names(endpoints: tuple[str, ...], timeout: float) -> None:
    """Log each endpoint whose name does not resolve, without waiting for it.

    It is only a warning: the name of a starting container may resolve while Zenoh tries, for up to `timeout` [s].
    """

    def warn(endpoint: str) -> None:
        if why := unresolved(endpoint):
            logging.getLogger("network").warning("%s: %s; trying for %g s", endpoint, why, timeout)

    for endpoint in endpoints:
        where = place(endpoint)
        if where is not None and not _is_literal(where.host):
            threading.Thread(target=warn, args=(endpoint,), name="resolve", daemon=True).start()


def _is_literal(host: str) -> bool:
    """True if `host` is an address and not a name."""
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
