"""Why a session did not open: Zenoh says little of it, so the connection is tried once more without Zenoh."""

import re
import socket
import ssl
from collections.abc import Mapping
from typing import Any

from fes.endpoints import Endpoints

PATIENCE = 2.0
"""How long to wait for an answer [s]."""

KEYLESS = "it asks for a certificate, and we have none: a world with --keys wants --keys"
"""What is said for whatever goes wrong over TLS without certificates of our own."""

_PLACE = re.compile(r"(?P<protocol>tcp|tls)/(?P<host>\S+):(?P<port>\d{1,5})")


def reason(endpoints: Endpoints, message: str) -> str:
    """Why a session did not open, in one line; `message` is what Zenoh says of it."""
    if "in use" in message.lower():
        return f"cannot listen on {', '.join(endpoints.listen)}: the address is already in use"
    if endpoints.mode == "client":
        for endpoint in endpoints.connect:
            if (why := complaint(endpoint, endpoints.security)) is not None:
                return f"cannot join the network at {endpoint}: {why}"
        return f"nobody listens on {endpoints.shown} (tried for {endpoints.timeout:g} s)"
    return f"cannot open a session on {endpoints.shown}: {first_line(message)}"


def first_line(message: str) -> str:
    """The first line of an error of Zenoh, without the places in its source."""
    line = message.strip().splitlines()[0] if message.strip() else "unknown error"
    return re.sub(r" at /\S+:\d+\.?", "", line)


def complaint(endpoint: str, security: Mapping[str, object]) -> str | None:
    """What is wrong between us and who listens at `endpoint`, in a few words; None if nothing is found, or nobody."""
    found = _PLACE.match(endpoint)
    if found is None:
        return None
    host = found["host"].strip("[]")
    try:
        with socket.create_connection((host, int(found["port"])), PATIENCE) as connection:
            if found["protocol"] == "tcp":
                return "somebody listens there, but opens no session: a world with --keys wants tls/ and --keys"
            return _over_tls(connection, host, security)
    except OSError:
        return None


def _over_tls(connection: socket.socket, host: str, security: Mapping[str, object]) -> str | None:
    files: Any = security.get("transport/link/tls", {})
    context = ssl.create_default_context(cafile=files.get("root_ca_certificate"))
    try:
        if "connect_certificate" in files:
            context.load_cert_chain(files["connect_certificate"], files["connect_private_key"])
        with context.wrap_socket(connection, server_hostname=host) as secure:
            secure.settimeout(PATIENCE)
            secure.recv(1)  # who listens judges our certificate after we have judged its own
    except ssl.SSLCertVerificationError as error:
        return f"its certificate is not to be trusted: {error.verify_message}" if files else KEYLESS
    except ssl.SSLError as error:
        reason = (error.reason or "unknown").lower().replace("_", " ")
        if "alert" in reason:
            return f"it refuses our certificate: {reason.rpartition('alert ')[2]}" if files else KEYLESS
        return f"it does not speak TLS: {reason}"
    except OSError:  # it waits for us to speak: so our certificate is good
        return None
    return None
