"""Contacts: the peers in range of each robot, and the last beacon of each. Neighbor rules choose among them."""

from dataclasses import dataclass

from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.sensing import Beacons

NEVER = -(2**62)
"""Stands for the tick of the last beacon of a peer that was never heard."""


@dataclass(frozen=True, eq=False)
class Lookup:
    """Index of each contact's beacon in the beacons of a tick; valid while neither set changes."""

    edges: Edges
    ids: Ints
    links: Edges
    sender: Ints
    """Row of the peer's beacon [m]; 0 where it is absent."""
    present: Bools
    """True if the peer's beacon exists [m]."""
    link: Ints
    """Position of the peer's link to this robot among all links, or -1 [m]."""

    def fits(self, edges: Edges, beacons: Beacons) -> bool:
        """True if this lookup is valid for these contacts and beacons."""
        return self.edges is edges and self.ids is beacons.ids and self.links is beacons.links


@dataclass(frozen=True, eq=False)
class Contacts:
    """The peers in range of each robot, and the last beacon of each; arrays over `edges` [m]."""

    edges: Edges
    lookup: Lookup
    heard: Ints
    """Tick of the last decoded beacon, or NEVER."""
    x: Floats
    y: Floats
    """Position in that beacon [m; world frame]."""
    estimates: Floats
    """The peer's own separation estimate for the link to this robot [m]; NaN if it has no such link."""
    selected_by_peer: Bools
    """True if the peer's neighbor rule chose this robot."""
    heard_separation: Floats
    """Separation at the tick of that beacon [m]."""
    known: Bools
    """True if the peer was heard within the timeout."""
    dx: Floats
    dy: Floats
    separation: Floats
    """Line of sight and its length [m; world frame], from the own pose of the previous tick. The peer's
    position is that of the same tick, unless its beacon was lost: then it is the last position heard."""
