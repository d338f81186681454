"""A crew whose tick is one call of the compiled core."""

import ctypes
from ctypes import c_int64, c_void_p
from functools import cache
from typing import NamedTuple

import numpy as np

from agents.control import clocks
from agents.control import crew as numpy_crew
from agents.control.state import Crew, CrewState
from agents.core import buffer, constants, self_test
from agents.core.buffer import Layout, Stored
from agents.core.constants import ALONE, POOLED, CrewConstants
from agents.core.structures import BeaconArrays, Input
from fes.arithmetic.core import library
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Bytes, Floats
from fes.model.sensing import Beacons, Observations, Telemetry

NEW_LINKS = 2
"""Flag of fes_crew_tick: the set of links has changed."""

NAME = "robots"


@cache
def load() -> ctypes.CDLL | None:
    """The robots' kernels; None where numpy computes."""
    return library.load(__file__, NAME, _passes)


def _passes(found: ctypes.CDLL) -> bool:
    """True if the kernels compute what they must."""
    found.fes_crew_layout.restype = found.fes_crew_tick.restype = c_int64
    found.fes_crew_layout.argtypes = [c_void_p, c_int64, c_void_p]
    found.fes_crew_tick.argtypes = [c_void_p, c_void_p, c_void_p, c_int64, c_void_p, c_int64, c_void_p]
    return self_test.digest(found) == self_test.EXPECTED


class Failed(Exception):
    """A tick that the core cannot compute: numpy computes it, and finds the reason."""


class Sent(NamedTuple):
    """The output of a tick."""

    beacons: Beacons
    twists: Floats
    telemetry: Telemetry


class CompiledCrew:
    """A crew's state in a buffer, and the call that moves it from tick to tick."""

    def __init__(self, library: ctypes.CDLL, crew: Crew, own: CrewConstants) -> None:
        self._library, self._crew, self._own = library, crew, own
        self._constants = ctypes.addressof(own.constants)
        self._layouts: dict[int, Layout] = {}
        self._input = Input()
        self._address = ctypes.addressof(self._input)
        self._in_range: Edges | None = None
        self._held: tuple[object, ...] = ()
        """Arrays to which the input points."""
        self._sent: Beacons | None = None
        self._capacity = 0
        self.stored = buffer.packed(numpy_crew.start(crew), self._layout(0))
        """The state."""
        n, kind = len(crew.ids), own.constants.seeking
        self._learnt = 2 if kind in (POOLED, ALONE) else 0
        self._nothing = np.zeros((n, 0)), np.zeros((n, 0), np.uint8), np.zeros((n, 0))
        self._links = no_edges(crew.ids)
        self._scratch = np.zeros(2 * n)

    @property
    def state(self) -> CrewState:
        """The state as the numpy code has it."""
        return buffer.unpacked(self.stored, self._crew, self._own)

    @state.setter
    def state(self, state: CrewState) -> None:
        self.stored = buffer.packed(state, self._layout(len(state.contacts.edges)))
        self._links, self._sent = state.links.edges, None

    def forget(self, restarted: Bools) -> None:
        """Let the robots `restarted` [n] know nothing."""
        self.state = numpy_crew.forget(self._crew, self.state, restarted)

    def step(self, observations: Observations, beacons: Beacons) -> Sent:
        """One tick. Raises Failed where a twist is not finite; the state is then that before the tick."""
        if observations.in_range is not self._in_range:
            self._range(observations.in_range)
        given, tick = self._input, observations.tick
        poses, reception = np.ascontiguousarray(observations.poses), observations.reception
        given.tick, given.poses, given.reception = tick, poses.ctypes.data, reception.ctypes.data
        if not self._crew.clocks.is_exact:
            skew = clocks.ahead(self._crew.clocks, tick)
            given.skew = skew.ctypes.data
        if beacons is not self._sent:
            self._hear(beacons)
        layout = self._layouts[self._capacity]
        after: Bytes = np.empty(layout.length, np.uint8)
        before, address = self.stored, after.ctypes.data
        flags = self._library.fes_crew_tick(
            self._constants,
            self._address,
            before.buffer.ctypes.data,
            before.layout.capacity,
            address,
            layout.capacity,
            self._scratch.ctypes.data,
        )
        if flags < 0:
            raise Failed
        self.stored = Stored(after, layout)
        return self._output(tick, flags, address)

    def _range(self, in_range: Edges) -> None:
        """Point to the peers in range."""
        begins, peers = np.ascontiguousarray(in_range.begins), np.ascontiguousarray(in_range.peers)
        self._in_range, self._held = in_range, (begins, peers)
        self._input.begin, self._input.in_range = begins.ctypes.data, peers.ctypes.data
        self._capacity = len(in_range)
        self._layout(self._capacity)
        needed = 2 * len(self._crew.ids) + self._capacity
        if len(self._scratch) < needed:
            self._scratch = np.zeros(needed)

    def _hear(self, beacons: Beacons) -> None:
        """Point to beacons that are not the crew's own last ones."""
        q = self._own.constants.statistics
        statistics = beacons.statistics if beacons.statistics.shape[1] == q else np.zeros((len(beacons.ids), q))
        arrays: list[np.ndarray] = [  # type: ignore[type-arg]
            np.ascontiguousarray(values)
            for values in (
                beacons.ids,
                beacons.poses,
                beacons.links.begins,
                beacons.links.peers,
                beacons.estimates,
                beacons.selected,
                statistics,
            )
        ]
        self._heard = arrays
        self._input.beacons = BeaconArrays(len(beacons.ids), *(values.ctypes.data for values in arrays))

    def _output(self, tick: int, flags: int, address: int) -> Sent:
        """The beacons, twists and telemetry in the buffer; the next tick hears these beacons."""
        crew, (buffer_, layout) = self._crew, self.stored
        n, places = len(crew.ids), layout.places
        if flags & NEW_LINKS:
            count = int(layout.view(buffer_, "link_begin", n + 1)[n])
            self._links = buffer.link_edges(crew.ids, self.stored, count)
        links = self._links
        count = len(links)
        poses: Floats = np.ndarray((n, 3), np.float64, buffer_, places["sent_poses"])
        estimates: Floats = np.ndarray(count, np.float64, buffer_, places["sent"])
        selected: Bools = np.ndarray(count, np.bool_, buffer_, places["selected"])
        twists: Floats = np.ndarray((n, 2), np.float64, buffer_, places["twists"])
        statistics, declared, details = self._nothing
        if self._own.constants.statistics:
            statistics = np.ndarray((n, 5), np.float64, buffer_, places["sent_statistics"])
        learnt: Floats = np.ndarray((self._learnt, count), np.float64, buffer_, places["learnt"])
        beacons = Beacons(tick, crew.ids, poses, links, estimates, selected, statistics, declared)
        own = self._input.beacons
        own.count, own.ids, own.poses = n, self._own.constants.ids, address + places["sent_poses"]
        own.begin, own.peers = address + places["link_begin"], address + places["link_peers"]
        own.estimates, own.selected = address + places["sent"], address + places["selected"]
        own.statistics = address + places["sent_statistics"]
        self._sent = beacons
        return Sent(beacons, twists, Telemetry(links, estimates, learnt, details))

    def _layout(self, capacity: int) -> Layout:
        if capacity not in self._layouts:
            self._layouts[capacity] = Layout(self._library, self._own, capacity)
        return self._layouts[capacity]


def of(crew: Crew) -> CompiledCrew | None:
    """The compiled crew of a crew; None where numpy computes: the core was not built, or lacks one of its laws."""
    library = load()
    own = constants.of(crew) if library is not None else None
    return None if library is None or own is None else CompiledCrew(library, crew, own)
