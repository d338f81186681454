"""Health check of a container: a port with a listener, or a connection to one.

`python -m fes.transport.health listens 7447` and `python -m fes.transport.health connected 7447` exit with 0 if so,
else with 1. They read the kernel's table of sockets in their own network namespace, the container's. So a
check every other second costs a run nothing and sends nothing. They need Linux.
"""

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

ESTABLISHED, LISTEN = "01", "0A"
"""States of a socket, as the kernel writes them."""

TABLES = (Path("/proc/net/tcp"), Path("/proc/net/tcp6"))


class Socket(NamedTuple):
    """A TCP socket of this network namespace."""

    address: str
    """Of this end, in hexadecimal."""
    port: int
    peer_port: int
    state: str


def sockets(tables: Iterable[str]) -> Iterator[Socket]:
    """The sockets in the text of kernel tables, such as /proc/net/tcp.

    >>> next(sockets(["  sl  local_address rem_address   st\\n   0: 0100007F:1D17 00000000:0000 0A"]))
    Socket(address='0100007F', port=7447, peer_port=0, state='0A')
    """
    for table in tables:
        for line in table.splitlines()[1:]:
            own, peer, state = line.split()[1:4]
            (address, port), (_, peer_port) = own.split(":"), peer.split(":")
            yield Socket(address, int(port, 16), int(peer_port, 16), state)


def own_sockets() -> Iterator[Socket]:
    """The sockets of this network namespace; raises OSError on another system than Linux."""
    return sockets(table.read_text(encoding="ascii") for table in TABLES if table == TABLES[0] or table.exists())


def healthy(how: str, port: int) -> bool:
    """True if a process `listens` at a port, or is `connected` to one; raises ValueError for another `how`."""
    if how == "listens":
        return any(socket.port == port and socket.state == LISTEN for socket in own_sockets())
    if how == "connected":
        return any(socket.peer_port == port and socket.state == ESTABLISHED for socket in own_sockets())
    raise ValueError(f"expects listens or connected, got '{how}'")


def main() -> None:
    """Entry point: exit code 0 if healthy, 1 if not, with one line that says what was looked for."""
    try:
        how, port = sys.argv[1:]
        well = healthy(how, int(port))
    except (ValueError, OSError) as error:
        sys.exit(f"fes.transport.health: error: expects listens PORT or connected PORT, on Linux: {error}")
    print(f"{how} {port}: {'yes' if well else 'no'}")
    sys.exit(0 if well else 1)


if __name__ == "__main__":
    main()
