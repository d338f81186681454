"""The addresses at which a process listens, as the kernel lists them."""

import contextlib
import os
import socket
import struct
from pathlib import Path

LISTENING = "0A"
"""State of a socket in /proc/net/tcp."""


def listening(pid: int) -> set[tuple[str, int]]:
    """Address and port of each TCP socket at which a process listens."""
    own = _sockets(pid)
    found: set[tuple[str, int]] = set()
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            words = line.split()
            if words[3] == LISTENING and words[9] in own:
                address, _, port = words[1].partition(":")
                found.add((_address(address), int(port, 16)))
    return found


def _sockets(pid: int) -> set[str]:
    """The inodes of a process's sockets."""
    inodes = set()
    for link in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):  # it was closed meanwhile
            target = os.readlink(link)
            if target.startswith("socket:["):
                inodes.add(target[8:-1])
    return inodes


def _address(text: str) -> str:
    """An address in the kernel's notation: words of 32 bits, in the order of this machine's bytes."""
    words = [int(text[index : index + 8], 16) for index in range(0, len(text), 8)]
    family = socket.AF_INET if len(words) == 1 else socket.AF_INET6
    return socket.inet_ntop(family, struct.pack(f"={len(words)}I", *words))
