"""The reason why a session did not open. Zenoh reports little, so the connection is tried once more without it."""

import re
import socket
import ssl
from collections.abc import Mapping
from typing import Any

from fes import errors
from fes.transport import addresses
from fes.transport.endpoints import Endpoints

PATIENCE = 2.0
"""Longest wait for an answer [s]."""

KEYLESS = "it asks for a certificate, and we have none: a world with --keys wants --keys"
"""Diagnosis of any error over TLS without certificates of our own."""

MUTE = "a process listens there, but opens no session"
SLOW = "or it is suspended or overloaded"
"""Diagnosis of a listener that does not answer."""


def reason(endpoints: Endpoints, message: str) -> str:
    """Reason why a session did not open, in one line; `message` is that of Zenoh's error."""
    if "in use" in message.lower():
        return f"cannot listen on {', '.join(endpoints.listen)}: the address is already in use"
    for endpoint in endpoints.listen:
        if why := _unusable(endpoint):
            return f"cannot listen on {endpoint}: {why}"
    for endpoint in endpoints.connect:
        if why := addresses.unresolved(endpoint):
            return f"cannot join the network at {endpoint}: {why} (tried for {endpoints.timeout:g} s)"
    if endpoints.mode == "client":
        for endpoint in endpoints.connect:
            if (wrong := complaint(endpoint, endpoints.security)) is not None:
                return f"cannot join the network at {endpoint}: {wrong}"
        return f"nothing listens on {endpoints.shown} (tried for {endpoints.timeout:g} s)"
    return f"cannot open a session on {endpoints.shown}: {first_line(message)}"


def first_line(message: str) -> str:
    """The first line of a Zenoh error, without locations in Zenoh's source.

    For an error that points into a text: the line and column in the text, and the error's last line, its reason.

    >>> first_line(" --> 1:2\\n  |\\n1 | {\\n  |  ^---\\n  |\\n  = expected identifier or string at /src/lib.rs:14.")
    'line 1, column 2: expected identifier or string'
    """
    lines = re.sub(r" at /\S+:\d+\.?", "", message).strip().splitlines() or ["unknown error"]
    place = re.fullmatch(r"--> (\d+):(\d+)", lines[0])
    return f"line {place[1]}, column {place[2]}: {lines[-1].strip(' =')}" if place else lines[0]


def complaint(endpoint: str, security: Mapping[str, object]) -> str | None:
    """Fault of the connection to `endpoint`, in a few words; None without a fault or a listener."""
    protocol, address = endpoint.partition("/")[0], addresses.place(endpoint)
    if address is None or protocol not in ("tcp", "tls"):
        return None
    host = address.host
    try:
        with socket.create_connection(address, PATIENCE) as connection:
            if protocol == "tcp":
                return f"{MUTE}: a world with --keys wants tls/ and --keys, {SLOW}"
            return _over_tls(connection, host, security)
    except ConnectionRefusedError:
        return None
    except TimeoutError:
        return f"nothing answers there within {PATIENCE:g} s"
    except OSError as error:
        return f"it cannot be reached: {errors.reason(error)}"


def _unusable(endpoint: str) -> str:
    """Reason why this machine cannot listen at `endpoint`, in a few words; empty if it can, or if that is unknown."""
    if why := addresses.unresolved(endpoint):
        return why
    where = addresses.place(endpoint)
    if where is None:
        return ""
    kind = socket.SOCK_DGRAM if endpoint.startswith(("udp/", "quic/")) else socket.SOCK_STREAM
    try:
        family, _, _, _, address = socket.getaddrinfo(*where, type=kind)[0]
        with socket.socket(family, kind) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except OSError as error:
        return errors.reason(error)
    return ""


def _over_tls(connection: socket.socket, host: str, security: Mapping[str, object]) -> str | None:
    answered = False
    files: Any = security.get("transport/link/tls", {})
    context = ssl.create_default_context(cafile=files.get("root_ca_certificate"))
    try:
        if "connect_certificate" in files:
            context.load_cert_chain(files["connect_certificate"], files["connect_private_key"])
        with context.wrap_socket(connection, server_hostname=host) as secure:
            answered = True
            secure.settimeout(PATIENCE)
            secure.recv(1)  # the listener verifies our certificate after we have verified its own
    except ssl.SSLCertVerificationError as error:
        return f"its certificate is not to be trusted: {error.verify_message}" if files else KEYLESS
    except ssl.SSLError as error:
        reason = (error.reason or "unknown").lower().replace("_", " ")
        if "alert" in reason:
            return f"it refuses our certificate: {reason.rpartition('alert ')[2]}" if files else KEYLESS
        return f"it does not speak TLS: {reason}"
    except OSError:  # if it waits for us to speak, our certificate is good
        return None if answered else f"{MUTE}: it speaks no TLS, {SLOW}"
    return None
