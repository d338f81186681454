"""Body frame and team frame: the law sees the body's poses moved, turned and scaled to its full size.

A twist is in the robot's own frame, so that it is scaled, and not turned.
"""

import math

from field.gate.rules.settings import Placement

Pose = tuple[float, float, float]
"""x, y, heading [m, m, rad]."""

Twist = tuple[float, float]
"""Linear and angular velocity [m/s, rad/s; the robot's own frame]."""


def to_team(placement: Placement, x: float, y: float, heading: float) -> Pose:
    """A pose of the body's frame [m of the body] as a pose of the team frame at full size.

    >>> to_team(Placement(scale=100.0, x=1.0, heading=math.pi / 2), 0.5, 0.0, 0.0)
    (100.0, 50.0, 1.5707963267948966)
    """
    cosine, sine = math.cos(placement.heading), math.sin(placement.heading)
    moved_x = cosine * x - sine * y + placement.x
    moved_y = sine * x + cosine * y + placement.y
    return placement.scale * moved_x, placement.scale * moved_y, wrapped(heading + placement.heading)


def wrapped(angle: float) -> float:
    """An angle from -π to π.

    >>> wrapped(1.5 * math.pi) == -0.5 * math.pi
    True
    """
    return math.remainder(angle, 2 * math.pi)


def moved(placement: Placement, pose: Pose, twist: Twist, dt: float) -> Pose:
    """A pose of the team frame after a body had a twist for `dt` [s], on an arc.

    >>> moved(Placement(scale=100.0), (0.0, 0.0, 0.0), (0.2, 0.0), 0.5)
    (10.0, 0.0, 0.0)
    """
    x, y, heading = pose
    travel, turn = placement.scale * twist[0] * dt, twist[1] * dt
    chord = travel * (math.sin(turn / 2) / (turn / 2) if turn else 1.0)
    middle = heading + turn / 2
    return x + chord * math.cos(middle), y + chord * math.sin(middle), heading + turn


def to_body_twist(placement: Placement, linear: float, angular: float) -> Twist:
    """A twist at full size as one of the body."""
    return linear / placement.scale, angular


def to_team_twist(placement: Placement, linear: float, angular: float) -> Twist:
    """A twist of the body at full size."""
    return linear * placement.scale, angular
