"""The slots of one peer: own ticks, each for one beacon.

The slot of a beacon is its tick plus an offset. The offset is fixed when the peer is first heard, so that this
beacon's slot is the next own step; the beacon is used one step later. This tick of patience keeps jitter from
becoming loss. The offset then follows the drift of the clocks.

- The peer's clock is slower: the offset grows, and one slot has no beacon. This inserted slot repeats the fate of the
  slot before, so it adds no loss of its own.
- The peer's clock is faster: the offset shrinks, and one beacon has no slot. It has no effect, so no slot has two
  chances.

Either change begins with the next tick that the peer has not been heard of. So the slot of a beacon does not depend
on the order of arrival.
"""

import math
from typing import NamedTuple

from fes.protocol.messages import Beacon
from field.senses.slot_counts import SlotCounts
from field.senses.steering import Steering

HORIZON = 16
"""Largest number of ticks that a beacon can be ahead of the own clock: memory has a bound."""


class Heard(NamedTuple):
    """A beacon, and the time of its arrival [own ticks]."""

    beacon: Beacon
    time: float


class Slots:
    """The slots of one peer, since its start or since it was first heard after a silence."""

    def __init__(self, boot: int, sequence: int, first: Heard, counts: SlotCounts) -> None:
        """The peer's start `boot` is first heard with the datagram `sequence`."""
        self.boot, self.last_heard, self.counts = boot, first.time, counts
        self.begin = math.floor(first.time) + 1
        """The first slot."""
        self._offset = self._old_offset = self.begin - first.beacon.tick
        self._from = self._until = first.beacon.tick
        """Ticks of the peer: before `_from` the old offset is valid, from `_until` on the new; between them none."""
        self._newest = first.beacon.tick, sequence
        self._waiting: dict[int, Heard] = {}
        self._used: set[int] = set()
        """Slots of the last ticks whose beacon has arrived."""
        self._inserted = -1
        """The slot without a beacon."""
        self._last: tuple[int, Heard | None] = (-1, None)
        """The last slot handed over."""
        self._steering = Steering()
        counts.starts += 1

    def hear(self, sequence: int, heard: Heard, stepped: int) -> None:
        """Hold a beacon for its slot; `stepped` is the tick of the last own step."""
        self.last_heard = max(self.last_heard, heard.time)
        slot = self._slot(heard.beacon.tick)
        if slot is None:
            self.counts.removed += 1
        elif slot in self._used:
            self.counts.repeated += 1
            return
        elif slot > max(stepped, math.floor(heard.time)) + HORIZON:
            self.counts.early += 1
        else:
            self._used.add(slot)
            if slot >= stepped:
                self._waiting[slot] = heard
            else:
                self.counts.late += 1
        self._advance(heard.beacon.tick, sequence)
        if slot is not None and (shift := self._steering.shift(slot + 1 - heard.time, heard.time)):
            self._change(shift)

    def take(self, tick: int) -> Heard | None:
        """The beacon of the slot before `tick`, None if it was lost. Each slot is taken once, in ascending order."""
        slot = tick - 1
        heard = self._waiting.pop(slot, None)
        skipped = [earlier for earlier in self._waiting if earlier < slot]
        for earlier in skipped:
            del self._waiting[earlier]
        self._used = {used for used in self._used if used > slot - HORIZON}
        self.counts.skipped += len(skipped)
        if heard is not None:
            self.counts.heard += 1
        elif slot == self._inserted:
            self.counts.inserted += 1
            heard = self._last[1] if self._last[0] == slot - 1 else None
        else:
            self.counts.missed += 1
        self._last = slot, heard
        return heard

    def _slot(self, tick: int) -> int | None:
        """The slot of the peer's tick; None if it has none."""
        if tick < self._from:
            return tick + self._old_offset
        return tick + self._offset if tick >= self._until else None

    def _advance(self, tick: int, sequence: int) -> None:
        """Count the ticks since the newest one in which the peer sent nothing."""
        newest, its_sequence = self._newest
        if tick > newest:
            self.counts.unsent += max(0, (tick - newest) - (sequence - its_sequence))
            self._newest = tick, sequence

    def _change(self, shift: int) -> None:
        """Change the offset by `shift`, from the next tick of the peer on."""
        self._old_offset, self._offset = self._offset, self._offset + shift
        self._from = self._newest[0] + 1
        self._until = self._from + max(0, -shift)
        if shift > 0:
            self._inserted = self._from + self._old_offset  # of several inserted slots the others are lost
