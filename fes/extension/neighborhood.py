"""The peers of each robot at one tick, as far as it heard them."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model import beacon_slots
from fes.model.beacon_slots import Slots
from fes.model.contacts import Contacts


class Neighborhood(NamedTuple):
    """The contacts of a crew of n robots, the robots of one process, and its links among them, at one tick.

    Pairs (robot, peer) are sorted by robot, then by peer: m contacts, l links. Arrays must not be written to.
    """

    tick: int
    """Number of the tick, from 0."""
    dt: float
    """Tick length [s]."""
    poses: Floats
    """Own poses at this tick [n, 3] [m, m, rad; world frame]."""
    contacts: Contacts
    """The peers that each robot has heard, with their last beacons: m of them."""
    before: Contacts
    """The contacts of the previous tick."""
    links: Edges
    """The links: contacts that the neighbor rule of either end selected [l]."""
    link_contact: Ints
    """Position of each link among the contacts [l]."""
    quality_weight: Floats | None = None
    """beta of the formation law of this tick: weight of ln q against ln c [n] [1]; None: 1."""

    @property
    def link_quality_weight(self) -> Floats | None:
        """beta of the robot of each link [l] [1]; None: 1."""
        return None if self.quality_weight is None else self.quality_weight.take(self.links.rows)

    @property
    def is_heard(self) -> Bools:
        """True for a contact whose beacon of the previous tick decoded [m]."""
        is_heard: Bools = np.equal(self.contacts.heard, self.tick - 1)
        return is_heard

    @property
    def peer_estimates(self) -> Floats:
        """The peer's own estimate for each link, by its last beacon [l] [m]; NaN if it has no such link."""
        return self.contacts.estimates.take(self.link_contact)

    @property
    def age(self) -> Floats:
        """Age of each link's last beacon [l] [s]."""
        return self.dt * (self.tick - self.contacts.heard.take(self.link_contact)).astype(np.float64)

    @property
    def slots(self) -> Slots:
        """The beacon slots of links that become known at this tick: decoded beacons, and those missed before them.

        Computed at each access.
        """
        is_link = np.zeros(len(self.contacts.edges), dtype=np.bool_)
        is_link[self.link_contact] = True
        return beacon_slots.between(self.before, self.contacts, self.tick, is_link)


class LinkGeometry(NamedTuple):
    """The links of a crew as the formation law sees them [l]."""

    separation: Floats
    """Length of the line of sight [l] [m]."""
    desired: Floats
    """Separation that the seeking law asks for [l] [m]."""
    bearing: Floats
    """Unit vector of the line of sight [2, l; world frame]."""
    without_dither: Floats | None = None
    """The desired separation without a physical dither [l] [m]; None: there is no such dither."""

    @property
    def estimates(self) -> Floats:
        """Estimate of the best separation of each link [l] [m]."""
        return self.desired if self.without_dither is None else self.without_dither

    @property
    def error(self) -> Floats:
        """Separation minus the desired one [l] [m]."""
        return self.separation - self.desired


@dataclass(frozen=True, eq=False)
class Entry:
    """The conditions at the tick at which new links begin."""

    tick: int
    """Number of the tick."""
    is_fresh: Bools
    """True for a robot whose initial graph is not complete yet: its own mean estimate does not count [n]."""
    reported: Floats
    """Mean estimate that the neighbors of each robot reported [n] [m]; NaN where none did."""
