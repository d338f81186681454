"""The channel `trace`: reception by time, sender and receiver, from a network simulator or a measurement."""

from functools import lru_cache
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
        self._table = table = _table(parameters.trace, parameters.trace_sha256)
        if table.largest >= context.robots:
            raise FesError(
                f"{parameters.trace}: sender and receiver must be from 0 to {context.robots - 1}, got {table.largest}"
            )
        self._latest: _Rows | None = None
        self._is_line = parameters.trace_between == "interpolated"
        self._earliness = TOLERANCE * context.dt

    def pair_probability(self, time: float, senders: Ints, receivers: Ints, separation: Floats) -> Floats:
        """Probability that a beacon of `time` [s] decodes, for each pair of ids [m]."""
        rank = int(np.searchsorted(self._table.times, time + self._earliness, "right"))
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
        table, wanted = self._table, Edges.key(receivers, senders)
        pair = np.minimum(np.searchsorted(table.pairs, wanted), len(table.pairs) - 1)
        row = np.searchsorted(table.place, pair * (len(table.times) + 1) + rank) - 1
        is_known = (table.pairs[pair] == wanted) & (row >= table.first[pair])
        after = np.where(row + 1 < table.end[pair], row + 1, row)
        value, length = np.where(is_known, table.value[row], 0.0), table.time[after] - table.time[row]
        value.flags.writeable = False  # the caller gets it as it is
        climb = np.where(is_known, table.value[after] - table.value[row], 0.0)
        return _Rows(senders, receivers, rank, value, table.time[row], np.where(length > 0.0, length, 1.0), climb)


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


class _Table(NamedTuple):
    """All rows of a file, by pair and time [k]."""

    time: Floats
    value: Floats
    place: Ints
    """Rank of the row's pair and time, ascending: one search finds the rows of all pairs."""
    times: Floats
    """All times of the file, ascending."""
    pairs: Ints
    """Keys of all pairs, ascending [p]."""
    first: Ints
    """First row of each pair [p]."""
    end: Ints
    """Row after the last one of each pair [p]."""
    largest: int
    """Largest id."""


@lru_cache(maxsize=1)
def _table(path: str, sha256: str) -> _Table:
    """The rows of a file: the runs of a sweep share them."""
    trace = trace_file.read(path, sha256)
    keys = Edges.key(trace.receiver, trace.sender)
    order = np.lexsort((trace.time, keys))
    keys, time = keys[order], trace.time[order]
    pairs, first = np.unique(keys, return_index=True)
    times, ranks = np.unique(time, return_inverse=True)
    place = np.searchsorted(pairs, keys) * (len(times) + 1) + ranks
    largest = int(max(trace.sender.max(), trace.receiver.max()))
    return _Table(
        time, trace.probability[order], place, times, pairs, first, np.append(first[1:], len(keys)), largest
    )
