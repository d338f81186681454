"""Counts of the beacons of one peer."""

from dataclasses import dataclass


@dataclass
class BeaconCounts:
    """Verdicts and beacons of one peer since the robot's start. Each own tick with a peer in range has a verdict."""

    heard: int = 0
    """Ticks with the verdict that a beacon decoded."""
    missed: int = 0
    """Ticks with the verdict that a beacon was lost."""
    concealed: int = 0
    """Ticks that repeat an earlier verdict, because nothing new was known: the peer or the network paused."""
    stale: int = 0
    """Those of the ticks heard and concealed that hand over no beacon, because none has arrived for long."""
    dropped: int = 0
    """Verdicts without a tick, because more of them waited than the network's delays require."""
    repeated: int = 0
    """Beacons that had arrived already, or arrived too late to count."""
    unsent: int = 0
    """Ticks in which the peer sent no beacon, by its sequence numbers: its own loop was late."""
    starts: int = 0
    """Times that the peer's verdicts began anew: at its start or this robot's, and after each silence."""
