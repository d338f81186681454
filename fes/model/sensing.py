"""Signals that a crew receives and sends in one tick, as arrays; the shells turn messages into these and back.

The world's observations hold what a robot senses, and the verdict of the radio: which beacons decoded. The shells
apply the verdict. So a crew gets only what a real robot could sense or receive.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

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

MAX_STATISTICS = 64
"""Largest number of statistics in a Beacon."""

MAX_DECLARED = 256
"""Largest number of bytes that the laws of a robot declare in a Beacon together."""

MAX_LEARNT = 16
"""Largest number of learnt numbers per link in a Command."""

MAX_DETAILS = 64
"""Largest number of further numbers in a Command."""


def bounded(values: Floats, most: float) -> Floats:
    """The values, clipped to [-`most`, `most`]; NaN remains."""
    return np.minimum(np.maximum(values, -most), most) if values.size else values


class Sensed(NamedTuple):
    """Measurements of the robots of a crew at one tick."""

    tick: int
    poses: Floats
    """Own poses, as measured last [n, 3] [m, m, rad; world frame]."""
    fixed: Ints | None = None
    """Tick at which each pose was measured [n]; None: all at this tick."""
    deviation: Floats | None = None
    """Standard deviation of each robot's own position along x and y [n] [m]; None: the poses are exact."""


@dataclass(frozen=True, eq=False)
class Observations:
    """The world's message to the robots of a crew at one tick: their measurements, and the verdict of the radio."""

    tick: int
    poses: Floats
    """Own poses, as measured last [n, 3] [m, m, rad; world frame]."""
    in_range: Edges
    """Peers within communication range at this tick [m]."""
    reception: Bytes
    """Reception of each peer's beacon of the previous tick: CLOSED, LOST or DECODED [m]."""
    fixed: Ints | None = None
    """Tick at which each pose was measured [n]; None: all at this tick."""

    @property
    def sensed(self) -> Sensed:
        """The measurements alone."""
        return Sensed(self.tick, self.poses, self.fixed)


class Received(NamedTuple):
    """The beacons of one tick that a crew received: those that decoded, and no others.

    Its arrays have one entry for each beacon that decoded at a robot [d].
    """

    tick: int
    """Tick of the beacons."""
    edges: Edges
    """The contacts: all peers in range that each robot has heard since they came in range [m]."""
    heard: Ints
    """Positions among the contacts, ascending [d]."""
    x: Floats
    y: Floats
    heading: Floats
    """Pose in the beacon [d] [m, m, rad; world frame]."""
    estimates: Floats
    """The sender's own separation estimate for the link to this robot [d] [m]; NaN if it has no such link."""
    selected: Bools
    """True if the sender's neighbor rule chose this robot [d]."""
    statistics: Floats
    """The sender's statistics [d, q]."""
    declared: Bytes
    """Bytes that the sender's laws declared [d, b]."""
    mean_estimates: Callable[[], Floats]
    """The sender's mean estimate over all its links [d] [m], NaN without links; computed on demand, as few ticks
    need it."""


class Beacons(NamedTuple):
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
    """Numbers of each sender's seeking law [n, q]; q = 0 if it has none."""
    declared: Bytes
    """Bytes that each sender's laws declared [n, b]; b = 0 if they declare none."""


class Telemetry(NamedTuple):
    """State of robots at one tick, for observers only."""

    links: Edges
    """The links in use [l]."""
    estimates: Floats
    """Separation estimate for each link [l] [m]."""
    learnt: Floats
    """Numbers that each link's robot has learnt [k, l]: those that the seeking law names. A measured run has level
    and exponent of ln(-ln p) = level + exponent ln(r / rho_0). k = 0 if the law learns none."""
    details: Floats
    """Further numbers of each robot [n, j]: those that the formation law names."""
    is_model_free: bool | None = None
    """True if no process of these robots has loaded the channel's formula; None where that is not known."""


def telemetry_of(telemetry: Telemetry, present: Bools) -> Telemetry:
    """The telemetry of the robots that are `present` [n]."""
    among = present[telemetry.links.rows]
    details = np.where(present[:, None], telemetry.details, np.nan)
    estimates, learnt = telemetry.estimates[among], telemetry.learnt[:, among]
    return Telemetry(telemetry.links.select(among), estimates, learnt, details, telemetry.is_model_free)


def no_telemetry(ids: Ints) -> Telemetry:
    """The telemetry of robots `ids` [n] before the first tick."""
    return Telemetry(no_edges(ids), np.zeros(0), np.zeros((0, 0)), np.zeros((len(ids), 0)))


def no_beacons() -> Beacons:
    """The beacons before the first tick: no robot has sent one."""
    ids, nothing, codes = np.zeros(0, dtype=np.int64), np.zeros((0, 0)), np.zeros((0, 0), dtype=np.uint8)
    return Beacons(-1, ids, np.zeros((0, 3)), no_edges(ids), np.zeros(0), np.zeros(0, dtype=np.bool_), nothing, codes)
