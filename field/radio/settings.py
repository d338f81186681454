"""Settings of a robot's radio."""

from typing import NamedTuple

GROUP = "239.70.69.83"
"""Multicast group of the beacons: one of those that each site may use as it likes (RFC 2365)."""

PORT = 7460


class RadioSettings(NamedTuple):
    """The network of the beacons, and the team's key."""

    group: str = GROUP
    """IPv4 multicast group that all robots join."""
    port: int = PORT
    """UDP port of all robots."""
    interface: str = ""
    """Network interface of the radio, such as wlan0; empty for the system's choice."""
    relay: str = ""
    """host:port of a relay that forwards beacons, for robots on one machine; empty for multicast."""
    key: bytes = b""
    """The team's key; empty for a checksum, which authenticates no sender."""
