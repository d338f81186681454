"""The formation law: twists that drive each separation to the desired one; equations (6), (7), (9)."""

import numpy as np

from fes.arrays import geometry
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.model.config import FormationConfig


def weights(links: Edges, separation_error: Floats) -> Floats:
    """Weights a_ij [l] of each robot's links; equation (9).

    Half the weight goes to the link with the largest |separation error| (among equals the lowest peer id). The other
    links share the other half; a single link has weight 1/2. With two or more neighbors the weights sum to 1, so
    a_ii = 0, although (1) asks for a_ii > 0. (9) is implemented as printed.
    """
    if len(links) == 0:
        return np.zeros(0)
    size = np.abs(separation_error)
    result = 0.5 / np.maximum(links.counts - 1, 1).take(links.rows)
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


def twist(vector: Floats, heading: Floats, dt: float, config: FormationConfig) -> Floats:
    """Twists [n, 2] [m/s, rad/s] to hold over a tick of `dt` [s]; equations (6), (7).

    `vector` [n, 2] [m] is g, held over the tick. (7) then turns the heading by delta' = -mu'|g| sin(delta), with
    delta the bearing of g from the heading. At mu' = 10 that is stiff (hundreds of rad/s). So omega is the mean rate
    of the exact flow, delta(h) = 2 atan(tan(delta_0 / 2) exp(-mu'|g| h)). v is that of (6) at the tick's beginning.
    """
    size = geometry.separation(vector[:, 0], vector[:, 1])
    begin = geometry.wrap(np.arctan2(vector[:, 1], vector[:, 0]) - heading)
    end = 2.0 * np.arctan(np.tan(0.5 * begin) * np.exp(-config.angular_gain * dt * size))
    result = np.empty((len(heading), 2))
    result[:, geometry.LINEAR] = config.linear_gain * size * np.cos(begin)
    result[:, geometry.ANGULAR] = (begin - end) / dt
    for column, limit in ((geometry.LINEAR, config.linear_limit), (geometry.ANGULAR, config.angular_limit)):
        if limit is not None:
            np.clip(result[:, column], -limit, limit, out=result[:, column])
    return result
