"""The table [radio] of robot.toml: the network of the beacons."""

from pathlib import Path
from typing import Annotated

from pydantic import Field

from fes.errors import FesError, reason
from fes.model.table import OwnTable
from field.radio.settings import GROUP, PORT, RadioSettings

SHORTEST_KEY, LONGEST_KEY = 16, 1024
"""Length of the key of a team [bytes]."""


class RadioConfig(OwnTable):
    """The network of the beacons: UDP multicast, or a relay for robots on one machine."""

    group: Annotated[str, Field(max_length=40)] = GROUP
    """IPv4 multicast group that all robots join."""
    port: Annotated[int, Field(ge=1, le=65535)] = PORT
    """UDP port of all robots."""
    interface: Annotated[str, Field(max_length=40)] = ""
    """Network interface of the radio, such as `wlan0`; empty for the system's choice."""
    relay: Annotated[str, Field(max_length=60)] = ""
    """Address HOST:PORT of a relay, instead of multicast, for robots on one machine; empty without one."""
    key_file: Annotated[str, Field(max_length=400)] = ""
    """File with the team's key; a relative path starts at the folder of robot.toml. Without a key, any program on the
    network can forge beacons."""

    def settings(self, folder: Path) -> RadioSettings:
        """The settings of the socket, with the key of a file in `folder`; raises FesError."""
        key = _key(folder / self.key_file) if self.key_file else b""
        return RadioSettings(self.group, self.port, self.interface, self.relay, key)


def _key(path: Path) -> bytes:
    """The key in a file; raises FesError."""
    try:
        with path.open("rb") as file:
            key = file.read(LONGEST_KEY + 1).strip()
    except OSError as error:
        raise FesError(f"radio.key_file: cannot read {path}: {reason(error, with_file=False)}") from None
    if not SHORTEST_KEY <= len(key) <= LONGEST_KEY:
        raise FesError(f"radio.key_file: a key has {SHORTEST_KEY} to {LONGEST_KEY} bytes: {path} has {len(key)}")
    return key
