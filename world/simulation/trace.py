"""The channel `trace`: reception by time, sender and receiver, from a network simulator or a measurement."""

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.errors import FesError
from fes.extension.context import WorldContext
from world.config.outside import trace_file
from world.config.radio import RadioConfig


class TraceChannel:
    """The values of a file. A pair that the file lacks, and a time before a pair's first row, decode nothing."""

    Parameters = RadioConfig

    def __init__(self, parameters: RadioConfig, context: WorldContext) -> None:
        assert parameters.trace is not None
        trace = trace_file.read(parameters.trace, parameters.trace_sha256)
        if len(trace.sender) and max(trace.sender.max(), trace.receiver.max()) >= context.robots:
            raise FesError(f"{parameters.trace}: it names a robot that is not one of {context.robots}")
        keys = Edges.key(trace.receiver, trace.sender)
        order = np.lexsort((trace.time, keys))
        self._keys, self._time = keys[order], trace.time[order]
        self._value = trace.probability[order]
        self._pairs, self._first = np.unique(self._keys, return_index=True)
        self._end = np.append(self._first[1:], len(self._keys))
        self._is_line = parameters.trace_between == "interpolated"

    def pair_probability(self, time: float, senders: Ints, receivers: Ints, separation: Floats) -> Floats:
        """Probability that a beacon of `time` [s] decodes, for each pair of ids [m]."""
        result = np.zeros(len(senders))
        if not len(self._pairs):
            return result
        wanted = Edges.key(receivers, senders)
        place = np.minimum(np.searchsorted(self._pairs, wanted), len(self._pairs) - 1)
        for entry in np.flatnonzero(self._pairs[place] == wanted).tolist():
            first, end = self._first[place[entry]], self._end[place[entry]]
            if self._is_line:
                inside = time >= self._time[first]
                value = np.interp(time, self._time[first:end], self._value[first:end]) if inside else 0.0
            else:
                last = int(np.searchsorted(self._time[first:end], time, "right")) - 1
                value = self._value[first + last] if last >= 0 else 0.0
            result[entry] = value
        return result
