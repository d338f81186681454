"""The channel `trace`: reception by time, sender and receiver, from a network simulator or a measurement."""

from typing import NamedTuple

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.errors import FesError
from fes.extension.context import WorldContext
from world.config.outside import trace_file
from world.config.radio import RadioConfig

TOLERANCE = 1e-6
"""A row acts at a tick that is this share of a tick earlier [1]: times in decimals are rounded."""


class TraceChannel:
    """The values of a file.

    A pair that the file lacks, and a time before a pair's first row, decode nothing. After its last row, a pair keeps
    that row's value. Of two rows of a pair at one time, the later one in the file counts.
    """

    Parameters = RadioConfig

    def __init__(self, parameters: RadioConfig, context: WorldContext) -> None:
        if parameters.trace is None or parameters.trace_sha256 is None:
            raise FesError("channel.model 'trace' needs `trace` and its checksum, which the scenario's file provides")
        trace = trace_file.read(parameters.trace, parameters.trace_sha256)
        largest = max(trace.sender.max(), trace.receiver.max())
        if largest >= context.robots:
            raise FesError(
                f"{parameters.trace}: sender and receiver must be from 0 to {context.robots - 1}, got {largest}"
            )
        keys = Edges.key(trace.receiver, trace.sender)
        order = np.lexsort((trace.time, keys))
        keys, self._time, self._value = keys[order], trace.time[order], trace.probability[order]
        self._pairs, self._first = np.unique(keys, return_index=True)
        self._times, ranks = np.unique(self._time, return_inverse=True)
        # by pair and time, in one ascending array: one search finds the rows of all pairs
        self._place = np.searchsorted(self._pairs, keys) * (len(self._times) + 1) + ranks
        self._end = np.append(self._first[1:], len(keys))
        self._latest: _Rows | None = None
        self._is_line = parameters.trace_between == "interpolated"
        self._earliness = TOLERANCE * context.dt

    def pair_probability(self, time: float, senders: Ints, receivers: Ints, separation: Floats) -> Floats:
        """Probability that a beacon of `time` [s] decodes, for each pair of ids [m]."""
        rank = int(np.searchsorted(self._times, time + self._earliness, "right"))
        latest = self._latest
        if latest is None or not (
            latest.senders is senders and latest.receivers is receivers and latest.rank == rank
        ):
            self._latest = latest = self._search(senders, receivers, rank)
        if not self._is_line:
            return latest.value
        share = np.clip((time - latest.since) / latest.length, 0.0, 1.0)
        probability: Floats = latest.value + latest.climb * share
        return probability

    def _search(self, senders: Ints, receivers: Ints, rank: int) -> "_Rows":
        """The rows in force for each pair of ids [m] after the first `rank` times of the file."""
        wanted = Edges.key(receivers, senders)
        pair = np.minimum(np.searchsorted(self._pairs, wanted), len(self._pairs) - 1)
        row = np.searchsorted(self._place, pair * (len(self._times) + 1) + rank) - 1
        is_known = (self._pairs[pair] == wanted) & (row >= self._first[pair])
        after = np.where(row + 1 < self._end[pair], row + 1, row)
        value, length = np.where(is_known, self._value[row], 0.0), self._time[after] - self._time[row]
        value.flags.writeable = False  # the caller gets it as it is
        climb = np.where(is_known, self._value[after] - self._value[row], 0.0)
        return _Rows(senders, receivers, rank, value, self._time[row], np.where(length > 0.0, length, 1.0), climb)


class _Rows(NamedTuple):
    """The rows in force: robots that keep their contacts need them again until the next time of the file."""

    senders: Ints
    receivers: Ints
    rank: int
    value: Floats
    since: Floats
    length: Floats
    """Time until the next row of the pair [m] [s]; 1 after the last row."""
    climb: Floats
    """Difference of the next row's value [m]; 0 after the last row."""
