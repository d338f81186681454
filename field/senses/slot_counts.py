"""Counts of the beacons of one peer."""

from dataclasses import dataclass


@dataclass
class SlotCounts:
    """Slots and beacons of one peer since the robot's start. A slot is an own tick while the peer is in range."""

    heard: int = 0
    """Slots whose beacon was handed to the crew."""
    missed: int = 0
    """Slots whose beacon did not arrive in time."""
    unsent: int = 0
    """Ticks that the peer did not send at all, by its sequence numbers: most of them are among `missed`."""
    late: int = 0
    """Beacons that arrived after their slot."""
    early: int = 0
    """Beacons that were far ahead of their slot."""
    repeated: int = 0
    """Beacons of a tick that had arrived already."""
    skipped: int = 0
    """Beacons of slots that the robot itself skipped, because its loop was late."""
    inserted: int = 0
    """Slots without a beacon, because the peer's clock is slower: each repeats the fate of the slot before."""
    removed: int = 0
    """Ticks of the peer without a slot, because its clock is faster: their beacons have no effect."""
    starts: int = 0
    """Times that the peer's slots were counted anew: at its start, and after each silence."""
