"""Normally distributed numbers as a function of (seed, stream, tick, robot), without the C library.

Each is the sum of 12 uniform numbers minus 6: mean 0, variance exactly 1, and never beyond 6. The additions have a
fixed order.
"""

import numpy as np

from fes.arithmetic import draws
from fes.arrays.types import Floats, Ints

TERMS = 12

_STEP = 4  # blocks begin and end in steps of so many ticks, as the generator's counters do
_BLOCK = 64  # ticks drawn at a time
_MOST = 1 << 20  # largest number of uniform numbers in a block, unless it has the fewest ticks


class Normals:
    """The numbers of one stream for the robots of a run. Its cache never changes a number."""

    def __init__(self, seed: int, stream: str, robots: int, columns: int) -> None:
        """Each robot gets `columns` numbers per tick."""
        self._key: Ints = draws.key(seed, stream)
        ids, terms = np.arange(robots), np.arange(TERMS * columns).reshape(columns, TERMS).T
        self._shape = TERMS, robots, columns
        self._senders = np.broadcast_to(ids[:, None], self._shape).reshape(-1)
        self._receivers = np.broadcast_to(terms[:, None, :], self._shape).reshape(-1)
        self._length = max(_STEP, min(_BLOCK, _MOST // len(self._senders) // _STEP * _STEP))
        self._first = -self._length
        self._block: Floats = np.zeros((0, robots, columns))

    def of(self, tick: int) -> Floats:
        """The numbers of a tick [n, columns]."""
        if not self._first <= tick < self._first + self._length:
            self._first = tick - tick % self._length
            drawn = draws.uniform_ticks(self._key, self._first, self._length, self._senders, self._receivers)
            uniform = drawn.reshape(-1, *self._shape)
            total = uniform[:, 0] - 6.0
            for term in range(1, TERMS):
                total = total + uniform[:, term]
            self._block = total
        numbers: Floats = self._block[tick - self._first]
        return numbers
