"""The formation law: where each robot is pulled, so that each separation becomes the desired one; equation (9)."""

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats
from fes.extension.context import LawContext
from fes.extension.neighborhood import LinkGeometry, Neighborhood
from fes.extension.protocols import Formed, NoParameters


def weights(links: Edges, separation_error: Floats) -> Floats:
    """Weights a_ij [l] of each robot's links; equation (9).

    Half the weight goes to the link with the largest |separation error| (among equals the lowest peer id). The other
    links share the other half; a single link has weight 1/2. With two or more neighbors the weights sum to 1, so
    a_ii = 0, although (1) asks for a_ii > 0. (9) is implemented as printed.
    """
    if len(links) == 0:
        return np.zeros(0)
    size = np.abs(separation_error)
    result = 0.5 * links.shares
    result[links.first_smallest(np.negative(size, out=size))] = 0.5
    return result


def formation_vector(links: Edges, separation_error: Floats, bearing: Floats) -> Floats:
    """g_i = sum_j a_ij (r_ij - r_des) [cos psi_ij, sin psi_ij], world frame [n, 2] [m].

    `bearing` [2, l] is the unit vector of the line of sight. (6) and (7) are its components along and
    across the heading: v = mu g.h, omega = mu' h x g.
    """
    force = weights(links, separation_error) * separation_error
    total = np.empty((len(links.ids), 2))
    total[:, 0] = links.sum(force * bearing[0])
    total[:, 1] = links.sum(force * bearing[1])
    return total


class PaperFormation:
    """The law of the paper: each robot is pulled by g_i."""

    Parameters = NoParameters
    declared = 0
    details: tuple[str, ...] = ()

    def __init__(self, parameters: NoParameters, context: LawContext) -> None:
        """It depends on nothing but its links."""

    def start(self) -> None:
        """It has no state."""

    def forget(self, state: None, restarted: Bools) -> None:
        """It has no state."""

    def step(self, state: None, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull g_i of each robot."""
        return Formed(None, formation_vector(around.links, links.error, links.bearing))
