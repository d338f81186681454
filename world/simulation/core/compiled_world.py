"""A world whose tick is one call of the compiled core, where its channel and its bodies are the core's."""

import ctypes
from ctypes import c_int64, c_void_p
from functools import cache
from typing import NamedTuple

import numpy as np

from fes.arithmetic.core import library
from fes.arithmetic.core.library import Buffer
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints, read_only
from world.config.radio import RadioConfig
from world.simulation import neighbor_list
from world.simulation.channel import Medium, Radio, RadioInput
from world.simulation.core import self_test
from world.simulation.core.link_kernels import LinkKernels
from world.simulation.core.stored_radio import StoredRadio
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


def _passes(loaded: ctypes.CDLL) -> bool:
    """True if the kernels compute what they must."""
    loaded.fes_world_layout.restype = loaded.fes_world_tick.restype = c_int64
    loaded.fes_world_layout.argtypes = [c_int64, c_int64, c_void_p]
    loaded.fes_world_tick.argtypes = [c_void_p] * 4
    loaded.fes_world_beacons.restype = loaded.fes_world_commands.restype = c_int64
    return self_test.digest(loaded) == self_test.EXPECTED


class CompiledWorld:
    """The call that moves a world from tick to tick, and the buffer of its last tick."""

    def __init__(self, library: ctypes.CDLL, ids: Ints, medium: Medium) -> None:
        self._library, self._ids, self._medium = library, ids, medium
        self._settings = Settings(dt=medium.dt)
        self._settings.key0, self._settings.key1 = (int(word) for word in medium.fading.key)
        self._config: RadioConfig | None = None
        self._is_usable = False
        self._poses, self._twists = np.zeros((len(ids), 3)), np.zeros((len(ids), 2))
        self._present: Bools | None = None
        self._input = Input(robots=len(ids), poses=self._poses.ctypes.data, twists=self._twists.ctypes.data)
        self._addresses = ctypes.addressof(self._settings), ctypes.addressof(self._input)
        self._layouts: dict[int, Layout] = {}
        self._candidates: Candidates | None = None
        """Those to which the input points."""
        self._last: tuple[Proximity, Radio] | None = None
        self._buffer: Buffer = (ctypes.c_char * 1)()
        """The tick of `_last`."""

    def can(self, config: RadioConfig) -> bool:
        """True if the core has this channel."""
        if config is not self._config:
            self._config = config
            others = config.shadowing or config.bursts or config.jammers or config.partition
            model = self._medium.reception.of(config)
            self._is_usable = type(model) is Formula and not others
            if self._is_usable:
                self._set(config, model.scale)
        return self._is_usable

    def step(self, config: RadioConfig, robots: RadioInput, radio: Radio, twists: Floats) -> Moved:
        """The world one tick later, with the bodies holding `twists` [n, 2]; only if it `can`."""
        given, near, factor = self._input, robots.proximity, robots.reception_factor
        if self._last is None or self._last[0] is not near or self._last[1] is not radio:
            self._store(near, radio)
        self._poses[...], self._twists[...] = robots.poses, twists
        if robots.present is not self._present:
            self._present = np.ascontiguousarray(robots.present)
            given.present = self._present.ctypes.data
        given.tick, given.factor = robots.tick, None if factor is None else factor.ctypes.data
        candidates, reach = near.candidates, config.communication_range
        after, flags = self._call(candidates)
        if flags == CANDIDATES_TOO_OLD or (candidates.positions is not None and candidates.reach != reach):
            poses = self._layout(len(candidates.a)).view(after, "poses", self._poses.shape)
            candidates = neighbor_list.find(poses, reach)
            after, flags = self._call(candidates, is_new=True)
        return self._moved(after, candidates, flags, near)

    def _call(self, candidates: Candidates, *, is_new: bool = False) -> tuple[Buffer, int]:
        """The next tick in a new buffer, with these candidates, and flags; a list that `is_new` is not checked."""
        if candidates is not self._candidates:
            self._point(candidates)
        after = self._layout(len(candidates.a)).buffer()
        positions = self._input.now.positions if is_new else None
        if is_new:  # a robot at infinity would have moved from any position
            self._input.now.positions = None
        before, address = ctypes.addressof(self._buffer), ctypes.addressof(after)
        flags = self._library.fes_world_tick(*self._addresses, before, address)
        if is_new:
            self._input.now.positions = positions
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

    def _moved(self, after: Buffer, candidates: Candidates, flags: int, near: Proximity) -> Moved:
        """The arrays in a buffer."""
        p, edges = len(candidates.a), near.edges
        layout, n = self._layout(p), len(self._ids)
        if flags & NEW_PAIRS:
            m = int(layout.view(after, "begin", n + 1)[n])
            rows, peers = layout.view(after, "rows", m).copy(), layout.view(after, "peers", m).copy()
            edges = Edges(self._ids, rows, peers)
        m, view = len(edges), layout.view
        given, separation = self._input, view(after, "separation", p)
        pair = view(after, "pair", m)
        proximity = Proximity(candidates, view(after, "mask", p), edges, pair, separation)
        vars(proximity)["least"] = given.least  # the core has found it
        now = StoredRadio.of(edges, layout, after)
        self._last, self._buffer = (proximity, now), after
        if near.candidates is not candidates:
            given.before = given.now
        return Moved(read_only(view(after, "poses", (n, 3))), proximity, now, given.sent, given.decoded)

    def _store(self, near: Proximity, radio: Radio) -> None:
        """Store a tick that numpy has computed, or that has been changed since."""
        layout, edges = self._layout(len(near.candidates.a)), near.edges
        self._buffer = layout.buffer()
        arrays = {"separation": near.separation, "begin": edges.begins, "peers": edges.peers, "pair": near.pair}
        for name, values in (arrays | {name: getattr(radio, name) for name in LEDGER}).items():
            layout.view(self._buffer, name, values.shape)[...] = values
        layout.view(self._buffer, "totals", TOTALS)[DRAWN] = -1  # no random words
        self._point(near.candidates)
        self._input.before = self._input.now
        self._last = near, radio

    def _set(self, config: RadioConfig, scale: float) -> None:
        """Let the settings name a channel."""
        settings = self._settings
        settings.communication_range, settings.is_certain = config.communication_range, config.is_certain
        settings.model = _MODELS[str(config.model)]
        settings.scale = scale
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
    loaded = load()
    return None if loaded is None else CompiledWorld(loaded, ids, medium)


@cache
def link_kernels() -> LinkKernels | None:
    """The functions for the links; None where numpy computes."""
    loaded = load()
    return None if loaded is None else LinkKernels(loaded)
