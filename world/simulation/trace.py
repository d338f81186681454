"""The channel `trace`: reception by time, sender and receiver, from a network simulator or a measurement."""

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
        self._is_line = parameters.trace_between == "interpolated"
        self._earliness = TOLERANCE * context.dt

    def pair_probability(self, time: float, senders: Ints, receivers: Ints, separation: Floats) -> Floats:
        """Probability that a beacon of `time` [s] decodes, for each pair of ids [m]."""
        wanted = Edges.key(receivers, senders)
        pair = np.minimum(np.searchsorted(self._pairs, wanted), len(self._pairs) - 1)
        rank = np.searchsorted(self._times, time + self._earliness, "right")
        row = np.searchsorted(self._place, pair * (len(self._times) + 1) + rank) - 1
        is_known = (self._pairs[pair] == wanted) & (row >= self._first[pair])
        value = self._value[row]
        if self._is_line:
            value = value + self._climb(time, pair, row)
        return np.where(is_known, value, 0.0)

    def _climb(self, time: float, pair: Ints, row: Ints) -> Floats:
        """Difference at `time` [s] from the value of each `row` to the line to the next row of its `pair` [m]."""
        end = np.append(self._first[1:], len(self._time))[pair]
        after = np.where(row + 1 < end, row + 1, row)
        length = self._time[after] - self._time[row]
        share = np.clip((time - self._time[row]) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        climb: Floats = (self._value[after] - self._value[row]) * share
        return climb
