"""Uniform random numbers for the pairs in range, drawn in advance."""

import numpy as np

from fes.arithmetic import draws
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Floats, Ints

_BLOCK = 128  # ticks drawn at a time: the cost is per pair, not per number
_MOST = 1 << 24  # largest number of cached numbers, unless four per pair are more
_STEP = 4  # ticks start and end in steps of so many, as the generator's counters do


class DrawCache:
    """Uniform random numbers for the pairs in range, drawn in advance in blocks of ticks.

    A cache, not a state: every number is a function of (seed, tick, sender, receiver).
    """

    def __init__(self, key: Ints) -> None:
        self.key = key
        self._edges = no_edges(np.zeros(0, dtype=np.int64))
        self._first = 0
        """The tick of the first row of `_block`."""
        self._since = 0
        """The first tick of which every pair of `_edges` has its number."""
        self._block: Floats = np.zeros((0, 0))
        """Numbers of the ticks from `_first` on; the columns of pairs that left the range are free."""
        self._columns: Ints = np.zeros(0, dtype=np.int64)
        """Column of each pair of `_edges`."""

    def numbers(self, tick: int, edges: Edges) -> Floats:
        """The numbers in [0, 1) of a tick for the pairs (receiver, sender) of `edges` [m]."""
        if not self._since <= tick < self._first + len(self._block):
            self._begin(tick, edges)
        elif edges is not self._edges:
            self._update(tick, edges)
        numbers: Floats = self._block[tick - self._first].take(self._columns)
        return numbers

    def _begin(self, tick: int, edges: Edges) -> None:
        """Draw a block for the pairs of `edges`, from `tick` on."""
        count = max(_STEP, min(_BLOCK, _MOST // (_STEP * max(1, len(edges))) * _STEP))
        self._first = self._since = tick - tick % _STEP
        self._block = np.zeros((0, 0))  # frees the last block before the next one is drawn
        self._block = draws.uniform_ticks(self.key, self._first, count, edges.peers, edges.robots)
        self._edges, self._columns = edges, np.arange(len(edges))

    def _update(self, tick: int, edges: Edges) -> None:
        """Assign columns to the pairs of `edges`; draw the numbers that new pairs still need."""
        columns = edges.carry(self._columns, self._edges, -1)
        new = np.flatnonzero(columns < 0)
        if len(new):
            count, capacity = self._block.shape
            if len(edges) > capacity and len(edges) * count > _MOST and count > _STEP:
                self._begin(tick, edges)
                return
            self._since = tick - tick % _STEP
            row = self._since - self._first
            if len(edges) > capacity:
                self._grow(len(edges), row)
            columns[new] = self._free(columns)[: len(new)]
            receivers = edges.ids[edges.rows[new]]
            drawn = draws.uniform_ticks(self.key, self._since, count - row, edges.peers[new], receivers)
            self._block[row:, columns[new]] = drawn
        self._edges, self._columns = edges, columns

    def _grow(self, pairs: int, row: int) -> None:
        """Make columns for at least so many pairs, and keep the rows from `row` on."""
        count, capacity = self._block.shape
        grown = np.empty((count, max(pairs, min(2 * capacity, _MOST // count))))
        grown[row:, :capacity] = self._block[row:]
        self._block = grown

    def _free(self, columns: Ints) -> Ints:
        """The columns of the block that are not among `columns`, in which -1 stands for none."""
        is_free = np.ones(self._block.shape[1], dtype=np.bool_)
        is_free[columns[columns >= 0]] = False
        return np.flatnonzero(is_free)
