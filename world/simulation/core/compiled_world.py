"""A world whose tick is one call of the compiled core, where its channel and its bodies are the core's."""

import ctypes
from ctypes import c_int64, c_void_p
from functools import cache
from typing import NamedTuple

import numpy as np

from fes.arithmetic.core import library
from fes.arrays.edges import Edges
from fes.arrays.types import Bytes, Floats, Ints, read_only
from fes.model import outage
from world.config.radio import RadioConfig
from world.simulation import neighbor_list
from world.simulation.channel import Medium, Radio, RadioInput
from world.simulation.core import self_test
from world.simulation.core.structures import DRAWN, LEDGER, TOTALS, CandidateList, Input, Layout, Settings
from world.simulation.formula import Formula
from world.simulation.neighbor_list import Candidates, Proximity

NAME = "world"

NEW_PAIRS, CANDIDATES_TOO_OLD = 1, -1
"""Results of fes_world_tick."""

_MODELS = {"rayleigh": 0, "logistic": 1, "perfect": 2}

class Moved(NamedTuple):
    """The world one tick later."""

    poses: Floats
    proximity: Proximity
    radio: Radio
    sent: int
    """Beacons sent on open contacts that are still in range."""
    decoded: int
    """Number of those that decoded."""


@cache
def load() -> ctypes.CDLL | None:
    """The world's kernels; None where numpy computes."""
    return library.load(__file__, NAME, _passes)


def _passes(found: ctypes.CDLL) -> bool:
    """True if the kernels compute what they must."""
    found.fes_world_layout.restype = found.fes_world_tick.restype = c_int64
    found.fes_world_layout.argtypes = [c_int64, c_int64, c_void_p]
    found.fes_world_tick.argtypes = [c_void_p] * 4
    return self_test.digest(found) == self_test.EXPECTED


class CompiledWorld:
    """The call that moves a world from tick to tick, and the buffer of its last tick."""

    def __init__(self, library: ctypes.CDLL, ids: Ints, medium: Medium) -> None:
        self._library, self._ids, self._medium = library, ids, medium
        self._settings = Settings(dt=medium.dt)
        self._settings.key0, self._settings.key1 = (int(word) for word in medium.fading.key)
        self._config: RadioConfig | None = None
        self._is_usable = False
        self._input = Input(robots=len(ids))
        self._addresses = ctypes.addressof(self._settings), ctypes.addressof(self._input)
        self._layouts: dict[int, Layout] = {}
        self._candidates: Candidates | None = None
        """Those to which the input points."""
        self._last: tuple[Proximity, Radio] | None = None
        self._buffer: Bytes = np.zeros(0, np.uint8)
        """The tick of `_last`."""

    def can(self, config: RadioConfig) -> bool:
        """True if the core has this channel."""
        if config is not self._config:
            self._config = config
            others = config.shadowing or config.bursts or config.jammers or config.partition
            self._is_usable = type(self._medium.reception.of(config)) is Formula and not others
            if self._is_usable:
                self._set(config)
        return self._is_usable

    def step(self, config: RadioConfig, robots: RadioInput, radio: Radio, twists: Floats) -> Moved:
        """The world one tick later, with the bodies holding `twists` [n, 2]; only if it `can`."""
        given, near, factor = self._input, robots.proximity, robots.reception_factor
        candidates = near.candidates
        if self._last is None or self._last[0] is not near or self._last[1] is not radio:
            self._store(near, radio)
        before = self._buffer
        poses, twists = np.ascontiguousarray(robots.poses), np.ascontiguousarray(twists)
        given.tick, given.poses, given.twists = robots.tick, poses.ctypes.data, twists.ctypes.data
        given.present = robots.present.ctypes.data
        given.factor = None if factor is None else factor.ctypes.data
        reach = config.communication_range
        after, flags = self._call(before, candidates)
        if flags == CANDIDATES_TOO_OLD or (candidates.positions is not None and candidates.reach != reach):
            layout = self._layout(len(candidates.a))
            candidates = neighbor_list.find(layout.view(after, "poses", (len(self._ids), 3)), reach)
            after, flags = self._call(before, candidates, is_new=True)
        return self._moved(after, candidates, flags, near, radio)

    def _call(self, before: Bytes, candidates: Candidates, *, is_new: bool = False) -> tuple[Bytes, int]:
        """The next tick in a new buffer, with these candidates, and the flags; a new list is not checked."""
        if candidates is not self._candidates:
            self._point(candidates)
        after: Bytes = np.empty(self._layout(len(candidates.a)).length, np.uint8)
        listed = self._input.now
        positions = listed.positions
        if is_new:  # a robot at infinity would have moved from any position
            listed.positions = None
        flags = self._library.fes_world_tick(*self._addresses, before.ctypes.data, after.ctypes.data)
        listed.positions = positions
        return after, flags

    def _point(self, candidates: Candidates) -> None:
        """Let the input name new candidates."""
        positions = candidates.positions
        self._input.now = CandidateList(
            len(candidates.a),
            candidates.a.ctypes.data,
            candidates.b.ctypes.data,
            None if positions is None else positions.ctypes.data,
            0.5 * neighbor_list.MARGIN * candidates.reach,
        )
        self._candidates = candidates

    def _moved(self, after: Bytes, candidates: Candidates, flags: int, near: Proximity, radio: Radio) -> Moved:
        """The arrays in a buffer."""
        layout, n, p = self._layout(len(candidates.a)), len(self._ids), len(candidates.a)
        edges = near.edges
        if flags & NEW_PAIRS:
            m = int(layout.view(after, "begin", n + 1)[n])
            rows, peers = layout.view(after, "rows", m).copy(), layout.view(after, "peers", m).copy()
            edges = Edges(self._ids, rows, peers)
        m, view = len(edges), layout.view
        proximity = Proximity(
            candidates, view(after, "mask", p), edges, view(after, "pair", m), view(after, "separation", p)
        )
        now = Radio(edges, *(view(after, name, m) for name in LEDGER))
        sent, decoded = view(after, "totals", 2).tolist()  # SENT, HEARD
        self._last, self._buffer, self._input.before = (proximity, now), after, self._input.now
        return Moved(read_only(view(after, "poses", (n, 3))), proximity, now, sent, decoded)

    def _store(self, near: Proximity, radio: Radio) -> None:
        """Store a tick that numpy has computed, or that has been changed since."""
        count, edges = len(near.candidates.a), near.edges
        layout = self._layout(count)
        self._buffer = np.zeros(layout.length, np.uint8)
        arrays = {"separation": near.separation, "begin": edges.begins, "peers": edges.peers, "pair": near.pair}
        for name, values in (arrays | {name: getattr(radio, name) for name in LEDGER}).items():
            layout.view(self._buffer, name, values.shape)[...] = values
        layout.view(self._buffer, "totals", TOTALS)[DRAWN] = -1  # no random words
        self._point(near.candidates)
        self._input.before = self._input.now
        self._last = near, radio

    def _set(self, config: RadioConfig) -> None:
        """Let the settings name a channel."""
        settings = self._settings
        settings.communication_range, settings.is_certain = config.communication_range, config.is_certain
        settings.model = _MODELS[str(config.model)]
        settings.scale = 0.0 if config.model == "logistic" else outage.exponent_scale(config)
        settings.exponent = config.path_loss_exponent
        settings.midpoint, settings.width = config.logistic_midpoint, config.logistic_width

    def _layout(self, candidates: int) -> Layout:
        if candidates not in self._layouts:
            if len(self._layouts) > 64:
                self._layouts.clear()
            self._layouts[candidates] = Layout(self._library, len(self._ids), candidates)
        return self._layouts[candidates]


def of(ids: Ints, medium: Medium) -> CompiledWorld | None:
    """The compiled world of robots `ids` [n] that are unicycles; None where numpy computes."""
    found = load()
    return None if found is None else CompiledWorld(found, ids, medium)
