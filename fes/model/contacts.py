"""Contacts: the peers that each robot has heard, and the last beacon of each. Neighbor rules choose among them."""

from typing import NamedTuple

from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Bytes, Floats, Ints

NEVER = -(2**62)
"""Stands for the tick of the last beacon of a peer that was never heard."""


class Contacts(NamedTuple):
    """The peers that each robot has heard since they came in range, and the last beacon of each; over `edges` [m]."""

    edges: Edges
    """The pairs (robot, peer)."""
    heard: Ints
    """Tick of the last decoded beacon [m]."""
    x: Floats
    y: Floats
    heading: Floats
    """Pose in that beacon [m] [m, m, rad; world frame]."""
    estimates: Floats
    """The peer's own separation estimate for the link to this robot [m]; NaN if it has no such link."""
    selected_by_peer: Bools
    """True if the peer's neighbor rule chose this robot."""
    statistics: Floats
    """The peer's statistics [m, q]."""
    declared: Bytes
    """Bytes that the peer's laws declared [m, b]: first those of its formation law, then those of its seeking law."""
    heard_separation: Floats
    """Separation at the tick of that beacon [m]."""
    known: Bools
    """True if the peer was heard within the timeout."""
    dx: Floats
    dy: Floats
    separation: Floats
    """Line of sight and its length [m; world frame], from the own pose of the previous tick. The peer's
    position is that of the same tick, unless its beacon was lost: then it is the last position heard."""
