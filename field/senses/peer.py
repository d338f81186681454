"""One peer that a robot has heard: its newest beacon, and a verdict for each own tick. Pure."""

import math
from typing import NamedTuple

from fes.protocol.messages import Beacon
from fes.protocol.sealed import Sealed
from field.senses.beacon_counts import BeaconCounts
from field.senses.verdicts import Verdicts


class Heard(NamedTuple):
    """A beacon, and the time of its arrival [own ticks]."""

    beacon: Beacon
    time: float


class Peer:
    """A peer since the first beacon of one start of its agent, or since the first one after a silence."""

    def __init__(self, sealed: Sealed, first: Heard, counts: BeaconCounts) -> None:
        """`first` is the first beacon that decoded, with its datagram `sealed`."""
        self.boot, self.last_heard, self.counts = sealed.boot, first.time, counts
        self.begin = math.floor(first.time) + 1
        """The first own tick after the first beacon. It has no verdict yet: the queue keeps one in reserve."""
        self._newest, self._sequence = first, sealed.sequence
        self._verdicts = Verdicts(sealed.sequence, counts)
        counts.starts += 1

    def hear(self, sealed: Sealed, heard: Heard) -> None:
        """Hear a further beacon of the same start."""
        self.last_heard = max(self.last_heard, heard.time)
        self._verdicts.hear(sealed.sequence)
        ahead = sealed.sequence - self._sequence
        if ahead > 0:
            ticks = heard.beacon.tick - self._newest.beacon.tick
            self.counts.unsent += max(0, ticks - ahead)
            self._newest, self._sequence = heard, sealed.sequence

    def take(self, tick: int, longest_age: int) -> Heard | None:
        """The newest beacon if the verdict of this own tick is that a beacon decoded; None if one was lost.

        A beacon older than `longest_age` [ticks] is not handed over: its pose is no longer true.
        """
        has_decoded = self._verdicts.next()
        if has_decoded and tick - self.last_heard > longest_age:
            self.counts.stale += 1
            return None
        return self._newest if has_decoded else None
