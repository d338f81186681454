"""A potential that keeps links, after Ji & Egerstedt, "Distributed coordination control ..." (IEEE T-RO 2007).

The tension of a link is y^2 / (R - y), with y its deviation from the desired separation d. It grows without bound as
the link's length approaches the reach, where R = reach - d, and as the robots approach each other, where R = d. Their
formation control has desired displacements; this one has desired separations, as all laws here.
"""

import numpy as np

from fes.extension import Bools, Floats, Formed, LawContext, LinkGeometry, Neighborhood, Positive, Table

CLOSEST = 0.1
"""Smallest R - y as a share of R [1]: the tension stays finite, and its stiffness below 55 gains."""


class ConnectivityParameters(Table):
    """The parameters of `connectivity`."""

    reach: Positive | None = None
    """Length at which a link breaks [m]; by default the separation with the largest tolerable outage (r_x)."""
    gain: Positive = 0.5
    """Stiffness of a link at its desired separation [1]."""


class Connectivity:
    """The formation law, over the links of the neighbor rule; it has no state."""

    Parameters = ConnectivityParameters
    declared = 0
    details: tuple[str, ...] = ()

    def __init__(self, parameters: ConnectivityParameters, context: LawContext) -> None:
        self._gain = parameters.gain
        self._reach = parameters.reach or context.objective.maximum_separation

    def start(self) -> None:
        """No state."""

    def forget(self, state: None, restarted: Bools) -> None:
        """No state."""

    def step(self, state: None, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull against the tension of each robot's links."""
        force = self.force(links.separation, links.desired)
        x, y = (around.links.sum(force * direction) for direction in links.bearing)
        return Formed(None, np.stack([x, y], axis=1))

    def force(self, separation: Floats, desired: Floats) -> Floats:
        """Pull toward the peer [m] along links of length `separation` [m]: the tension's slope times gain R / 2."""
        error = separation - desired
        room = np.where(error > 0.0, np.maximum(self._reach - desired, 1e-9), desired)
        share = np.minimum(np.abs(error) / room, 1.0 - CLOSEST)
        stiffness = 0.5 * (2.0 - share) / np.square(1.0 - share)
        return self._gain * stiffness * np.sign(error) * share * room
