"""Gradient control of communication, after Heng Li, Peng, Liu, Gao & Zhang, "Communication-aware formation" (2015).

Each robot climbs the sum over its neighbors of the link quality phi(r) = g(r) a(r). The near field
g = r / sqrt(r^2 + r_0^2) falls when robots come close. The reception a = exp(-alpha (2^delta - 1) (r/r_ref)^nu) falls
when they part; alpha is the inverse of the reference SNR. The law is told the channel, so a is the true reception.
"""

import numpy as np

from fes.extension import (
    Bools,
    Floats,
    Formed,
    LawContext,
    LinkGeometry,
    Neighborhood,
    NonNegative,
    Positive,
    Table,
)


class GradientParameters(Table):
    """The parameters of `gradient`."""

    near_field: Positive | None = None
    """Length r_0 of the near field [m]; by default the smallest separation that the team prefers (r_min)."""
    least_reception: NonNegative = 0.7
    """Reception probability below which a peer is not a neighbor [1] (P_T)."""
    gain: Positive = 5000.0
    """Pull per slope of the link quality [m^2]."""


class Gradient:
    """The formation law that climbs the quality of the links. It has no state."""

    Parameters = GradientParameters
    knows_channel = True
    declared = 0
    details = ("link_quality", "neighbor_distance")
    """J_n and r_n of a robot: the mean quality of the links to its neighbors, and their mean distance [m]."""

    def __init__(self, parameters: GradientParameters, context: LawContext) -> None:
        assert context.channel is not None
        self._parameters, self._channel = parameters, context.channel
        self._near_field = parameters.near_field or context.objective.minimum_separation

    def start(self) -> None:
        """No state."""

    def forget(self, state: None, restarted: Bools) -> None:
        """No state."""

    def step(self, state: None, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull along the gradient, toward or away from every peer that is heard well enough."""
        contacts = around.contacts
        edges, separation = contacts.edges, np.maximum(contacts.separation, 1e-9)
        reception = self._channel.probability(separation)
        slope = reception * self._channel.log_slope(separation)
        is_neighbor = contacts.known & (reception >= self._parameters.least_reception)
        near, near_slope = self._near(separation)
        toward = np.where(is_neighbor, -self._parameters.gain * (near_slope * reception + near * slope), 0.0)
        pull = np.stack(
            [edges.sum(toward * contacts.dx / separation), edges.sum(toward * contacts.dy / separation)], axis=1
        )
        count = np.maximum(edges.sum(is_neighbor.astype(np.float64)), 1.0)
        quality = edges.sum(np.where(is_neighbor, near * reception, 0.0)) / count
        distance = edges.sum(np.where(is_neighbor, separation, 0.0)) / count
        return Formed(None, pull, details=np.stack([quality, distance], axis=1))

    def _near(self, separation: Floats) -> tuple[Floats, Floats]:
        """The near field at `separation` [m] and its slope [1/m], of the same shape."""
        square = self._near_field * self._near_field
        length = np.sqrt(separation * separation + square)
        return separation / length, square / (length * length * length)
