"""A crew whose tick is one call of the compiled core."""

import ctypes
from ctypes import c_char_p, c_int64, c_void_p
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
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats
from fes.model.sensing import Beacons, Observations, Telemetry

NEW_LINKS = 2
"""Flag of fes_crew_tick: the set of links has changed."""

NAME = "robots"


@cache
def load() -> ctypes.CDLL | None:
    """The robots' kernels; None where numpy computes."""
    return library.load(__file__, NAME, _passes)


def _passes(loaded: ctypes.CDLL) -> bool:
    """True if the kernels compute what they must."""
    loaded.fes_crew_layout.restype = loaded.fes_crew_tick.restype = c_int64
    loaded.fes_crew_layout.argtypes = [c_void_p, c_int64, c_void_p]
    loaded.fes_crew_tick.argtypes = [c_void_p, c_void_p, c_void_p, c_int64, c_void_p, c_int64, c_void_p]
    loaded.fes_agent_tick.restype = c_int64
    loaded.fes_agent_tick.argtypes = [*[c_void_p] * 4, c_int64, *[c_void_p] * 3, c_char_p, c_char_p]
    loaded.fes_crew_payloads.restype = c_int64
    loaded.fes_crew_payloads.argtypes = [c_void_p, c_void_p, c_void_p, c_void_p, c_int64, c_void_p, c_void_p]
    return self_test.digest(loaded) == self_test.EXPECTED


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
        self._library, self.crew, self._own = library, crew, own
        self.statistics: int = own.constants.statistics
        """Numbers in each beacon, q."""
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
        self._links: Edges | None = None
        """The links in the state; None if they must be read from there."""
        self._poses, self._reception = np.zeros((n, 3)), np.zeros(0, np.uint8)
        self._input.poses = self._poses.ctypes.data
        self._scratch, self._scratch_address = np.zeros(0), 0
        self._fit(0)

    @property
    def state(self) -> CrewState:
        """The state as the numpy code has it."""
        return buffer.unpacked(self.stored, self.crew, self._own)

    @state.setter
    def state(self, state: CrewState) -> None:
        self.stored = buffer.packed(state, self._layout(len(state.contacts.edges)))
        self._links, self._sent = state.links.edges, None

    @property
    def last(self) -> tuple[Floats, Floats, Bools]:
        """Poses [n, 3] and twists [n, 2] of the last tick, and True for a robot that has had it [n]."""
        (buffer_, layout), n = self.stored, len(self.crew.ids)
        poses, twists = layout.view(buffer_, "poses", (n, 3)), layout.view(buffer_, "twists", (n, 2))
        return poses.copy(), twists.copy(), layout.view(buffer_, "since", n) < np.iinfo(np.int64).max // 2

    def forget(self, restarted: Bools) -> None:
        """Let the robots `restarted` [n] know nothing."""
        self.state = numpy_crew.forget(self.crew, self.state, restarted)

    def step(self, observations: Observations, beacons: Beacons) -> Sent:
        """One tick. Raises Failed where a twist is not finite; the state is then that before the tick."""
        if observations.in_range is not self._in_range:
            self._range(observations.in_range)
        given, tick = self._input, observations.tick
        self._poses[...], self._reception[...] = observations.poses, observations.reception
        given.tick = tick
        if not self.crew.clocks.is_exact:
            skew = self.skew(tick)
            given.skew = None if skew is None else skew.ctypes.data
        if beacons is not self._sent:
            self._hear(beacons)
        layout, before = self._layouts[self._capacity], self.stored
        after = layout.buffer()
        flags = self._library.fes_crew_tick(
            self._constants,
            self._address,
            ctypes.addressof(before.buffer),
            before.layout.capacity,
            ctypes.addressof(after),
            layout.capacity,
            self._scratch_address,
        )
        if flags < 0:
            raise Failed
        self.stored = Stored(after, layout)
        return self._output(tick, flags)

    def skew(self, tick: int) -> Floats | None:
        """Skew of each robot's clock at a tick [n] [s]; None if all are exact."""
        return None if self.crew.clocks.is_exact else clocks.ahead(self.crew.clocks, tick)

    def step_bytes(
        self, messages: int, given: int, capacity: int, in_range: int, observations: bytes, beacons: bytes
    ) -> int:
        """One tick by the messages at an address, for `agents.core.byte_crew`: the result of fes_agent_tick."""
        layout, before = self._layout(capacity), self.stored
        self._fit(capacity)
        after = layout.buffer()
        flags: int = self._library.fes_agent_tick(
            self._constants,
            messages,
            given,
            before.address,
            before.layout.capacity,
            ctypes.addressof(after),
            self._scratch_address,
            in_range,
            observations,
            beacons,
        )
        if flags >= 0:
            self.stored, self._links, self._sent = Stored(after, layout), None, None
        return flags

    def has_sent(self, beacons: Beacons) -> bool:
        """True if these are the beacons of the last tick, so that input and state are those of this tick."""
        return beacons is self._sent

    def write(self, messages: int, present: int, decodable: int) -> int:
        """The messages of the last tick, for `agents.core.payload_writer`: the result of fes_crew_payloads."""
        buffer_, layout = self.stored
        length: int = self._library.fes_crew_payloads(
            self._constants,
            messages,
            self._address,
            ctypes.addressof(buffer_),
            layout.capacity,
            present,
            decodable,
        )
        return length

    def _range(self, in_range: Edges) -> None:
        """Point to the peers in range."""
        begins, peers = np.ascontiguousarray(in_range.begins), np.ascontiguousarray(in_range.peers)
        self._in_range, self._held = in_range, (begins, peers)
        self._input.begin, self._input.in_range = begins.ctypes.data, peers.ctypes.data
        self._reception = np.zeros(len(peers), np.uint8)
        self._input.reception = self._reception.ctypes.data
        self._capacity = len(in_range)
        self._layout(self._capacity)
        self._fit(self._capacity)

    def _fit(self, capacity: int) -> None:
        """Make the scratch large enough for `capacity` contacts."""
        needed = 2 * len(self.crew.ids) + capacity
        if len(self._scratch) < needed:
            self._scratch = np.zeros(needed)
            self._scratch_address = self._scratch.ctypes.data

    def _hear(self, beacons: Beacons) -> None:
        """Point to beacons that are not the crew's own last ones."""
        q = self._own.constants.statistics
        statistics = beacons.statistics if beacons.statistics.shape[1] == q else np.zeros((len(beacons.ids), q))
        arrays = [
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

    def _output(self, tick: int, flags: int) -> Sent:
        """The beacons, twists and telemetry in the buffer; the next tick hears these beacons."""
        crew, (buffer_, layout) = self.crew, self.stored
        n, places = len(crew.ids), layout.places
        links = None if flags & NEW_LINKS else self._links
        if links is None:
            count = int(layout.view(buffer_, "link_begin", n + 1)[n])
            links = self._links = buffer.link_edges(crew.ids, self.stored, count)
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
        self._input.beacons.count = -1  # these
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
