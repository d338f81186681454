"""Angles and separations in the plane [m, rad; world frame]."""

import math

import numpy as np

from fes.arrays.types import Floats

X, Y, HEADING = 0, 1, 2
"""Columns of an array of poses [n, 3]: Pose(x, y, heading) [m, m, rad; world frame], after ROS REP 103."""

LINEAR, ANGULAR = 0, 1
"""Columns of an array of twists [n, 2]: Twist(linear, angular) [m/s, rad/s; body frame]."""


def wrap(angle: Floats) -> Floats:
    """The same angle [rad] in [-pi, pi), up to rounding at the ends.

    >>> wrap(np.array([3 * math.pi, 0.5]))
    array([-3.14159265,  0.5       ])
    """
    return np.remainder(angle + math.pi, 2 * math.pi) - math.pi


def separation(dx: Floats, dy: Floats) -> Floats:
    """Length [m] of the line of sight (dx, dy) [m]; the same to the bit from either end.

    >>> float(separation(np.float64(3.0), np.float64(-4.0)))
    5.0
    """
    return np.sqrt(dx * dx + dy * dy)


def distances(positions: Floats) -> Floats:
    """Distance of each two of `positions` [..., n, 2] [m] [..., n, n].

    >>> distances(np.array([[0.0, 0.0], [3.0, 4.0]])).tolist()
    [[0.0, 5.0], [5.0, 0.0]]
    """
    x, y = positions[..., 0], positions[..., 1]
    return separation(x[..., :, None] - x[..., None, :], y[..., :, None] - y[..., None, :])
