"""Normally distributed numbers as a function of (seed, stream, tick, robot), without the C library.

Each is the sum of 12 uniform numbers minus 6: mean 0, variance exactly 1, and never beyond 6. The additions have a
fixed order.
"""

import numpy as np

from fes.arithmetic import draws
from fes.arrays.types import Floats, Ints

TERMS = 12

_BLOCK = 4  # ticks drawn at a time, as the generator's counters come


class Normals:
    """The numbers of one stream for the robots of a run. Its cache never changes a number."""

    def __init__(self, seed: int, stream: str, robots: int, columns: int) -> None:
        """Each robot gets `columns` numbers per tick."""
        self._key: Ints = draws.key(seed, stream)
        self._shape = TERMS, columns, robots
        ids, terms = np.arange(robots), np.arange(TERMS * columns)
        self._senders, self._receivers = np.tile(ids, len(terms)), np.repeat(terms, robots)
        self._first = -_BLOCK
        self._block: Floats = np.zeros((0, 0))

    def at(self, tick: int) -> Floats:
        """The numbers of a tick [n, columns]."""
        if not self._first <= tick < self._first + _BLOCK:
            self._first = tick - tick % _BLOCK
            self._block = draws.uniform_ticks(self._key, self._first, _BLOCK, self._senders, self._receivers)
        uniform = self._block[tick - self._first].reshape(self._shape)
        total = uniform[0] - 6.0
        for term in range(1, TERMS):
            total = total + uniform[term]
        return total.T
