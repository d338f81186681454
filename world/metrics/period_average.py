"""Separations averaged over a period of the dither.

With a physical dither the formation oscillates, and lags the desired separation. Its average over a period is the
separation at which it settles.
"""

from collections import deque

import numpy as np

from fes.arithmetic import sums
from fes.arrays.edges import Edges, Transition, no_edges
from fes.arrays.types import Floats, Ints

MOST_BLOCKS = 20
"""Largest number of blocks per period; the average is updated at the end of each block."""


class PeriodAverage:
    """Average of each link's separation over the latest complete period; call `add` once per tick."""

    def __init__(self, period: int) -> None:
        """`period` [ticks] is at least 1; with 1 the average is the separation itself."""
        self._period = period
        blocks = next(count for count in range(min(MOST_BLOCKS, period), 0, -1) if period % count == 0)
        self._length = period // blocks
        """Ticks per block."""
        self._blocks: deque[Floats] = deque(maxlen=blocks)
        self._links: Edges = no_edges(np.zeros(0, dtype=np.int64))
        self._now: Floats = np.zeros(0)
        self._ticks = 0
        self.mean: Floats = np.zeros(0)
        """Average per link [u] [m]; NaN for a link younger than a period."""

    def add(self, links: Edges, separation: Floats) -> None:
        """Add a tick: the links in use, and the separations of `links.undirected` [u] [m]."""
        if self._period == 1:
            self.mean = separation
            return
        if links is not self._links:
            self._carry(links)
        self._now = self._now + separation
        self._ticks += 1
        if self._ticks == self._length:
            self._blocks.append(self._now)
            self._now, self._ticks = np.zeros(len(separation)), 0
            if len(self._blocks) == self._blocks.maxlen:
                self.mean = sums.of_columns(np.array(self._blocks)) / self._period

    def _carry(self, links: Edges) -> None:
        """Carry the sums of links that stay; those of new links are NaN until a period has passed."""
        old, self._links = self._links, links
        links_after = Transition(_positions(links, old))
        begun = self._ticks > 0 or len(self._blocks) > 0
        for index, block in enumerate(self._blocks):
            self._blocks[index] = links_after.carry(block, np.nan)
        self._now = links_after.carry(self._now, np.nan if begun else 0.0)
        self.mean = links_after.carry(self.mean, np.nan)


def _positions(links: Edges, old: Edges) -> Ints:
    """Position in `old.undirected` of each link in `links.undirected`, or -1, in either direction."""
    rank = np.full(len(old) + 1, -1)  # the last stays -1, for links that are new
    rank[old.undirected] = np.arange(len(old.undirected))
    pairs = links.undirected
    forth, back = old.find(links.keys[pairs]), old.find(links.reverse_keys[pairs])
    positions: Ints = np.maximum(rank[forth], rank[back])
    return positions
