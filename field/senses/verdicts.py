"""Verdicts on a peer's beacons, decoded or lost: one per own tick, from sequence numbers. Pure.

A beacon shows which beacons before it were lost: those whose sequence numbers it skips. Verdicts wait in a queue, in
the order of sending, and each own tick takes the oldest. So jitter and pauses of a process or of the network do not
count as loss, and two clocks that drift apart need no alignment.

- The queue is empty: nothing is known yet. The tick *conceals* it, as telephones conceal lost packets: it repeats a
  verdict of the last HISTORY ones, each in turn. This leaves the share of losses as it is. The verdicts that come
  later make the queue longer, so the next pause of this length needs no concealment.
- The queue was never empty within a WINDOW: the tick drops its oldest verdicts, as many as were never needed. The
  choice does not depend on the verdicts, so this too leaves the share as it is.

A strong link has a verdict or two in its queue, and a weak link as many as its longest run of losses. A verdict is
late by that time, whether the beacon decoded or not.

A network that changes the order may deliver a beacon after its verdict was used as a loss. The next loss then counts
as decoded: so each beacon counts once.
"""

from collections import deque

from field.senses.beacon_counts import BeaconCounts

LONGEST = 64
"""Largest number of verdicts that wait; older ones are dropped."""

HISTORY = 64
"""Verdicts that are remembered for concealment."""

WINDOW = 500
"""Ticks after which the unused part of the queue is dropped."""

SPARE = 1
"""Verdicts that are kept in reserve, even if a window has not needed them."""


class Verdicts:
    """The verdicts on the beacons of one start of a peer."""

    def __init__(self, sequence: int, counts: BeaconCounts) -> None:
        """The first beacon that decoded has this `sequence` number."""
        self._counts = counts
        self._newest = sequence
        self._waiting = deque([True])
        self._past: deque[bool] = deque(maxlen=HISTORY)
        self._unused, self._ticks = LONGEST, 0
        """Fewest verdicts that waited after a tick of this window, and the number of its ticks."""
        self._used_as_lost: deque[int] = deque(maxlen=LONGEST)
        """Sequence numbers of the last losses."""
        self._owed = 0
        """Beacons that arrived after they had counted as lost."""

    def hear(self, sequence: int) -> None:
        """A beacon with this sequence number has decoded."""
        ahead = sequence - self._newest
        if ahead > 0:
            lost = min(ahead - 1, LONGEST)
            self._waiting.extend([*[False] * lost, True])
            self._newest = sequence
            self._drop(len(self._waiting) - LONGEST)
            return
        place = len(self._waiting) - 1 + ahead
        if place >= 0 and not self._waiting[place]:
            self._waiting[place] = True
        elif sequence in self._used_as_lost:
            self._used_as_lost.remove(sequence)
            self._owed += 1
        else:
            self._counts.repeated += 1

    def next(self) -> bool:
        """The verdict of the next own tick: True if a beacon decoded."""
        if not self._waiting:
            self._counts.concealed += 1
            verdict = self._past.popleft()
        else:
            verdict = self._take_oldest()
        self._past.append(verdict)
        self._shorten()
        return verdict

    def _take_oldest(self) -> bool:
        """The oldest verdict that waits."""
        sequence = self._newest - len(self._waiting) + 1
        verdict = self._waiting.popleft()
        if not verdict:
            self._used_as_lost.append(sequence)
            if self._owed:
                self._owed, verdict = self._owed - 1, True
        self._counts.heard += verdict
        self._counts.missed += not verdict
        return verdict

    def _shorten(self) -> None:
        """At the end of a window, drop the verdicts that it has not needed."""
        self._unused, self._ticks = min(self._unused, len(self._waiting)), self._ticks + 1
        if self._ticks == WINDOW:
            self._drop(self._unused - SPARE)
            self._unused, self._ticks = LONGEST, 0

    def _drop(self, number: int) -> None:
        """Drop the oldest verdicts; a negative number drops none."""
        for _ in range(number):
            self._waiting.popleft()
            self._counts.dropped += 1
