"""The radio: whose beacon decodes at whom.

A beacon is put on the air by every robot at every tick. Between two robots in range it decodes with the
reception probability (3) at their separation of that tick, independently for each tick and direction
(Rayleigh block fading). A contact opens two ticks after the robots came in range.
"""

from dataclasses import dataclass

import numpy as np

from fes import draws, outage
from fes.arrays import Bytes, Floats, Ints
from fes.config import ChannelConfig
from fes.edges import Edges
from fes.sensing import CLOSED, DECODED, LOST, OPENING_TICKS
from world.proximity import Proximity

_BLOCK = 128  # ticks of numbers drawn at a time: drawing costs per pair, not per number
_MOST = 1 << 24  # numbers held at most


@dataclass(frozen=True, eq=False)
class Radio:
    """What the radio did at one tick, over the pairs in range [m]."""

    edges: Edges
    """(receiver, sender)"""
    age: Ints
    """Ticks since each pair came in range [m]."""
    reception: Bytes
    """What became of the previous tick's beacon: CLOSED, LOST or DECODED [m]."""
    sent: Ints
    """Beacons sent on each contact since it opened [m]."""
    decoded: Ints
    """Beacons decoded on it [m]."""


class Draws:
    """Uniform numbers for the pairs in range, drawn ahead in blocks of ticks.

    A cache, not a state: every number is a function of (seed, tick, sender, receiver).
    """

    def __init__(self, key: Ints) -> None:
        self._key = key
        self._edges: Edges | None = None
        self._first = 0
        self._blocks: Floats = np.zeros((0, 0))
        """Numbers of the ticks from `_first` on, a column a pair, in the order in which pairs came."""
        self._columns: Ints = np.zeros(0, dtype=np.int64)
        """Column of each pair of `_edges`."""

    def at(self, tick: int, edges: Edges) -> Floats:
        """The numbers of one tick for (receiver, sender) `edges` [m], in [0, 1)."""
        if not 0 <= tick - self._first < len(self._blocks):
            count = max(4, min(_BLOCK, _MOST // (4 * max(1, len(edges))) * 4))
            self._first, self._edges = tick - tick % count, None
            self._blocks = np.zeros((count, 0))
        if edges is not self._edges:
            self._take_in(edges)
        numbers: Floats = self._blocks[tick - self._first].take(self._columns)
        return numbers

    def _take_in(self, edges: Edges) -> None:
        """Columns for the pairs of `edges`; only those that have none yet are drawn."""
        at = edges.places_in(self._edges).copy() if self._edges is not None else np.full(len(edges), -1)
        new = np.flatnonzero(at < 0)
        columns = self._columns.take(at, mode="clip") if len(self._columns) else at
        columns[new] = self._blocks.shape[1] + np.arange(len(new))
        receivers = edges.ids[edges.rows[new]]
        drawn = draws.uniform_ticks(self._key, self._first, len(self._blocks), edges.peers[new], receivers)
        self._blocks = np.concatenate([self._blocks, drawn], axis=1)
        self._edges, self._columns = edges, columns


def quiet(edges: Edges) -> Radio:
    """The radio before the first tick: nothing was sent."""
    nothing = np.zeros(len(edges), dtype=np.int64)
    return Radio(edges, nothing, nothing.astype(np.uint8), nothing, nothing)


def transmit(
    radio: Radio, tick: int, before: Proximity, after: Proximity, config: ChannelConfig, numbers: Draws
) -> Radio:
    """The radio at tick + 1: what became of the beacons of `tick`, sent at the separations of `before`."""
    edges = after.edges
    if edges is before.edges:
        age, sent, decoded = radio.age + 1, radio.sent, radio.decoded
        separation = before.separation.take(before.pair)
    else:
        at = edges.places_in(before.edges)
        stays = at >= 0
        age = np.where(stays, radio.age.take(at, mode="clip") + 1, 0) if len(before.edges) else 0 * edges.rows
        sent = np.where(stays, radio.sent.take(at, mode="clip"), 0) if len(before.edges) else 0 * edges.rows
        decoded = np.where(stays, radio.decoded.take(at, mode="clip"), 0) if len(before.edges) else sent
        separation = np.zeros(len(edges))
        separation[stays] = before.separation[before.pair[at[stays]]]
    is_open = age >= OPENING_TICKS
    heard = is_open
    if config.model != "perfect":
        heard = is_open & (numbers.at(tick, edges) < outage.reception_probability(separation, config))
    reception = np.where(heard, DECODED, np.where(is_open, LOST, CLOSED)).astype(np.uint8)
    return Radio(edges, age, reception, sent + is_open, decoded + heard)
