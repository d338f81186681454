"""Uniform random numbers for the pairs in range, drawn in advance."""

import numpy as np

from fes.arrays import draws
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Floats, Ints

_BLOCK = 128  # ticks drawn at a time: the cost is per pair, not per number
_MOST = 1 << 24  # largest number of cached numbers


class DrawCache:
    """Uniform random numbers for the pairs in range, drawn in advance in blocks of ticks.

    A cache, not a state: every number is a function of (seed, tick, sender, receiver).
    """

    def __init__(self, key: Ints) -> None:
        self.key = key
        self._edges = no_edges(np.zeros(0, dtype=np.int64))
        self._first = 0
        self._blocks: Floats = np.zeros((0, 0))
        """Numbers of the ticks from `_first` on, one column per pair, in the order in which pairs came in range."""
        self._columns: Ints = np.zeros(0, dtype=np.int64)
        """Column of each pair of `_edges`."""

    def numbers(self, tick: int, edges: Edges) -> Floats:
        """The numbers in [0, 1) of a tick for the pairs (receiver, sender) of `edges` [m]."""
        if not 0 <= tick - self._first < len(self._blocks):
            count = max(4, min(_BLOCK, _MOST // (4 * max(1, len(edges))) * 4))
            self._first, self._edges = tick - tick % count, no_edges(edges.ids)
            self._blocks, self._columns = np.zeros((count, 0)), self._edges.rows
        if edges is not self._edges:
            self._update(edges)
        numbers: Floats = self._blocks[tick - self._first].take(self._columns)
        return numbers

    def _update(self, edges: Edges) -> None:
        """Assign columns to the pairs of `edges`; draw those of new pairs."""
        columns = edges.carry(self._columns, self._edges, -1)
        new = np.flatnonzero(columns < 0)
        columns[new] = self._blocks.shape[1] + np.arange(len(new))
        receivers = edges.ids[edges.rows[new]]
        drawn = draws.uniform_ticks(self.key, self._first, len(self._blocks), edges.peers[new], receivers)
        self._blocks = np.concatenate([self._blocks, drawn], axis=1) if self._blocks.size else drawn
        self._edges, self._columns = edges, columns
