"""Single kernels of the robots' library, on states in buffers."""

import ctypes
from ctypes import c_int64, c_void_p
from typing import Any

import numpy as np

from agents.control import clocks
from agents.control.contacts import no_contacts
from agents.control.links import no_links
from agents.control.state import Crew, CrewState
from agents.core import buffer, compiled_crew, constants
from agents.core.buffer import Layout, Stored
from agents.core.structures import BeaconArrays, Input
from fes.arrays.types import Bools, Floats
from fes.model.contacts import NEVER
from fes.model.sensing import Beacons, Observations
from tests.support.random_teams import Round

CONTACTS, RULE, LINKS, PULL, GIVE_WAY, TWISTS, SLOW_DOWN, MEASURED, MEASURED_SEEK, PERTURBATION_SEEK = range(10)
"""Numbers of the kernels in kernels.c."""


class Kernels:
    """The kernels for one crew."""

    def __init__(self, crew: Crew) -> None:
        library, own = compiled_crew.load(), constants.of(crew)
        assert library is not None
        assert own is not None, "the core lacks a law of this crew"
        library.fes_crew_kernel.restype = c_int64
        library.fes_crew_kernel.argtypes = [
            c_int64, c_void_p, c_void_p, c_void_p, c_int64, c_void_p, c_int64, c_void_p, c_void_p
        ]  # fmt: skip
        self.library, self.crew, self.own = library, crew, own

    def stored(self, state: CrewState, capacity: int) -> Stored:
        """A state in a buffer with room for `capacity` contacts."""
        return buffer.packed(state, Layout(self.library, self.own, capacity))

    def unpacked(self, stored: Stored) -> CrewState:
        """The state of a buffer as numpy has it."""
        return buffer.unpacked(stored, self.crew, self.own)

    def call(self, kernel: int, one: Round, after: Stored, numbers: Any = None, more: Any = None) -> None:
        """Run a kernel, from the state before a tick, on the buffer of the state after it."""
        before = self.stored(one.before, len(one.before.contacts.edges))
        given, arrays = self._input(one.observations, one.beacons)
        pointers = (0 if values is None else values.ctypes.data for values in (numbers, more))
        sizes = before.layout.capacity, after.address, after.layout.capacity
        code = self.library.fes_crew_kernel(
            kernel,
            ctypes.addressof(self.own.constants),
            ctypes.addressof(given),
            before.address,
            *sizes,
            *pointers,
        )
        assert code == 0
        assert arrays  # which the input points to

    def contacts(self, one: Round) -> CrewState:
        """The contacts after the beacons of a tick."""
        blank = one.before._replace(
            contacts=self._no_contacts(), links=no_links(self.crew.ids), seeking=self._start()
        )
        after = self.stored(blank, len(one.observations.in_range))
        self.call(CONTACTS, one, after)
        return self.unpacked(after)

    def selected(self, one: Round) -> Bools:
        """The contacts that the neighbor rule selects [m]."""
        after, result = self._known(one), np.full(len(one.known.edges) + 1, 7, np.uint8)
        self.call(RULE, one, after, result)
        assert result[-1] == 7
        return result[:-1].astype(np.bool_)

    def linked(self, one: Round) -> tuple[CrewState, Bools]:
        """The state with its new links, and which of them the robots themselves selected [l]."""
        after, chosen = self._known(one), np.append(one.selected, False).astype(np.uint8)
        self.call(LINKS, one, after, chosen)
        state = self.unpacked(after)
        selected: Bools = after.layout.view(after.buffer, "selected", len(state.links.edges)).copy()
        return state, selected

    def pull(self, one: Round, desired: Floats) -> Floats:
        """The pull of the formation law [n, 2]."""
        result = np.full((len(self.crew.ids), 2), np.nan)
        self.call(PULL, one, self.relinked(one), np.append(desired, 0.0), result)
        return result

    def give_way(self, one: Round, pull: Floats) -> Floats:
        """The pull with which the robots give way [n, 2]."""
        result = pull.copy()
        self.call(GIVE_WAY, one, self.relinked(one), result)
        return result

    def twists(self, one: Round, pull: Floats) -> Floats:
        """The twists that follow a pull [n, 2]."""
        result = np.full_like(pull, np.nan)
        self.call(TWISTS, one, self.relinked(one), pull.copy(), result)
        return result

    def slow_down(self, one: Round, twists: Floats) -> Floats:
        """The twists that keep robots apart [n, 2]."""
        after = self.relinked(one)
        view = after.layout.view(after.buffer, "twists", twists.shape)
        view[...] = twists
        self.call(SLOW_DOWN, one, after)
        result: Floats = view.copy()
        return result

    def measured(self, one: Round) -> Any:
        """The seeking state after the beacons were counted."""
        after = self.relinked(one)
        capacity, length = after.layout.capacity, len(after.buffer)
        transition = one.known.edges.after(one.before.contacts.edges)
        m = len(one.known.edges)
        heard = np.ndarray(m, np.int64, after.buffer, length - 16 * capacity)
        heard[...] = transition.carry(one.before.contacts.heard, NEVER)
        apart = np.ndarray(m, np.float64, after.buffer, length - 8 * capacity)
        apart[...] = transition.carry(one.before.contacts.heard_separation, 0.0)
        self.call(MEASURED, one, after)
        return self.unpacked(after).seeking

    def seek(self, one: Round, kernel: int, seeking: Any) -> Any:
        """The seeking state a tick later."""
        after = self.stored(one.relinked._replace(seeking=seeking), len(one.observations.in_range))
        self.call(kernel, one, after)
        return self.unpacked(after).seeking

    def relinked(self, one: Round) -> Stored:
        """The state with the new links, in a buffer."""
        return self.stored(one.relinked, len(one.observations.in_range))

    def _known(self, one: Round) -> Stored:
        """The state with the new contacts, but without links."""
        state = one.relinked._replace(
            links=no_links(self.crew.ids), seeking=self._start(), linked_since=one.before.linked_since
        )
        return self.stored(state, len(one.observations.in_range))

    def _start(self) -> Any:
        return self.crew.seeking.start()

    def _no_contacts(self) -> Any:
        return no_contacts(self.crew.ids, self.crew.seeking.statistics, 0)

    def _input(self, observations: Observations, beacons: Beacons) -> tuple[Input, list[Any]]:
        """The inputs of a tick, and the arrays that they point to."""
        q, n = self.own.constants.statistics, len(beacons.ids)
        statistics = beacons.statistics if beacons.statistics.shape[1] == q else np.zeros((n, q))
        links = beacons.links
        sent = [
            beacons.ids,
            beacons.poses,
            links.begins,
            links.peers,
            beacons.estimates,
            beacons.selected,
            statistics,
        ]
        near = observations.in_range
        own: list[Any] = [observations.poses, near.begins, near.peers, observations.reception]
        sent, own = ([np.ascontiguousarray(values) for values in arrays] for arrays in (sent, own))
        given = Input(observations.tick, own[0].ctypes.data, None, *(values.ctypes.data for values in own[1:]))
        given.beacons = BeaconArrays(n, *(values.ctypes.data for values in sent))
        skew = clocks.ahead(self.crew.clocks, observations.tick)
        if not self.crew.clocks.is_exact:
            given.skew = skew.ctypes.data
        return given, [*sent, *own, skew]
