"""Signals that a crew receives and sends in one tick, as arrays; the shells turn messages into these and back.

An observation holds only what a real robot could sense or receive.
"""

from dataclasses import dataclass

import numpy as np

from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Bytes, Floats, Ints

CLOSED, LOST, DECODED = 0, 1, 2
"""Reception of a peer's last beacon: its radio contact is not open yet; it was lost on the air; it decoded."""

OPENING_TICKS = 2
"""A contact opens this many ticks after a peer comes in range: the rule of the radio in every backend."""

MAX_NUMBER = 1e12
"""Largest magnitude of a number in a Beacon, and of an estimate in a Command. Robots send no larger numbers, and
reject them: their squares and powers would overflow in the law of a peer, which would then have no twist."""

MAX_TWIST = 1e9
"""Largest magnitude of a linear [m/s] or angular [rad/s] velocity in a Command, for the same reason."""


def bounded(values: Floats, most: float) -> Floats:
    """The values, clipped to [-`most`, `most`]; NaN remains."""
    return np.minimum(np.maximum(values, -most), most)


@dataclass(frozen=True, eq=False)
class Observations:
    """Measurements of the robots of a crew at one tick."""

    tick: int
    poses: Floats
    """Own poses at this tick [n, 3] [m, m, rad; world frame]."""
    in_range: Edges
    """Peers within communication range at this tick [m]."""
    reception: Bytes
    """Reception of each peer's beacon of the previous tick: CLOSED, LOST or DECODED [m]."""


@dataclass(frozen=True, eq=False)
class Beacons:
    """Beacons of robots to their peers at one tick."""

    tick: int
    ids: Ints
    """Senders, ascending [n]."""
    poses: Floats
    """Senders' poses [n, 3] [m, m, rad; world frame]."""
    links: Edges
    """The links each sender uses [l]."""
    estimates: Floats
    """Its separation estimate for each link [l] [m]."""
    selected: Bools
    """True if the robot's own neighbor rule chose the link; else only the peer's rule did [l]."""
    statistics: Floats
    """Statistics of the channel that each sender has measured [n, q]; q = 0 if no robot measures."""


@dataclass(frozen=True, eq=False)
class Telemetry:
    """State of robots at one tick, for observers only."""

    links: Edges
    """The links in use [l]."""
    estimates: Floats
    """Separation estimate for each link [l] [m]."""
    learnt: Floats
    """Parameters of reception that each link's robot has learnt: rows level and exponent of
    ln(-ln p) = level + exponent ln(r / rho_0) [2, l]; [2, 0] if no robot measures."""


def telemetry_of(telemetry: Telemetry, present: Bools) -> Telemetry:
    """The telemetry of the robots that are `present` [n]."""
    among = present[telemetry.links.rows]
    learnt = telemetry.learnt[:, among] if telemetry.learnt.size else telemetry.learnt
    return Telemetry(telemetry.links.select(among), telemetry.estimates[among], learnt)


def no_telemetry(ids: Ints) -> Telemetry:
    """The telemetry of robots `ids` [n] before the first tick."""
    return Telemetry(no_edges(ids), np.zeros(0), np.zeros((2, 0)))


def no_beacons() -> Beacons:
    """The beacons before the first tick: no robot has sent one."""
    ids = np.zeros(0, dtype=np.int64)
    return Beacons(
        -1, ids, np.zeros((0, 3)), no_edges(ids), np.zeros(0), np.zeros(0, dtype=np.bool_), np.zeros((0, 0))
    )
