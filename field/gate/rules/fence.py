"""The polygon that a robot must not leave, and the distance in which the robot can brake before it.

The gate checks a twist before it sends it. The body then moves at this twist for the longest period L of the gate's
loop, and brakes at the limits a and α of its accelerations. It travels at most v²/2a + v L, and turns by at most
ω²/2α + ω L. The border must be farther away, in each direction that the robot can take meanwhile. Between two poses
the gate moves the last one by the twists that it has sent.

Errors of the pose are not included, nor is a body that lags or moves faster than commanded.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from field.gate.rules.frames import Pose, Twist
from field.gate.rules.settings import Settings

Corner = tuple[float, float]

HEADING = 0.05
"""Tolerated error of the heading [rad]."""


def is_inside(fence: Sequence[Corner], x: float, y: float) -> bool:
    """True if a point lies in a polygon, or there is no polygon; on its border the result is either.

    A ray from the point to the right crosses the border of its polygon an odd number of times. The polygon may be
    concave, and its corners may run either way.

    >>> square = (0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)
    >>> is_inside(square, 0.5, 0.5), is_inside(square, 1.5, 0.5), is_inside((), 1e9, 0.0)
    (True, False, True)
    """
    if not fence:
        return True
    is_odd = False
    for (x1, y1), (x2, y2) in pairwise((*fence, fence[0])):
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) / (y2 - y1) * (x2 - x1):
            is_odd = not is_odd
    return is_odd


def is_clear(fence: Sequence[Corner], pose: Pose, reach: float, turn: float) -> bool:
    """True if no border lies within `reach` [m] of a pose, in directions up to `turn` [rad] from its heading.

    From π/2 on every direction counts.

    >>> square = (0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)
    >>> is_clear(square, (0.9, 0.5, 0.0), 0.2, 0.1), is_clear(square, (0.9, 0.5, math.pi), 0.2, 0.1)
    (False, True)
    """
    for first, second in _ahead(fence, pose):
        part = (first, second) if turn >= math.pi / 2 else _between(first, second, turn)
        if part is not None and _distance(*part) <= reach:
            return False
    return True


def braking_problem(settings: Settings, pose: Pose, twist: Twist) -> str:
    """The reason why a robot at this pose must not get a twist, in one line; empty if it may."""
    if not settings.fence or twist[0] == 0:
        return ""
    limits, longest = settings.limits, settings.timing.longest_period
    speed, rate = abs(twist[0]), abs(twist[1])
    reach = settings.placement.scale * (speed * speed / (2 * limits.acceleration) + speed * longest)
    turn = rate * rate / (2 * limits.angular_acceleration) + rate * longest + HEADING
    x, y, heading = pose
    ahead = heading if twist[0] > 0 else heading + math.pi
    if is_clear(settings.fence, (x, y, ahead), reach, turn):
        return ""
    return f"the fence is within the braking distance, {reach:.2f} m: {x:.2f}, {y:.2f} m"


def _ahead(fence: Sequence[Corner], pose: Pose) -> Iterator[tuple[Corner, Corner]]:
    """The edges of a polygon in the frame of a robot, whose x axis points ahead."""
    x, y, heading = pose
    cosine, sine = math.cos(heading), math.sin(heading)
    corners = [(cosine * (a - x) + sine * (b - y), cosine * (b - y) - sine * (a - x)) for a, b in fence]
    return pairwise((*corners, *corners[:1]))


def _between(first: Corner, second: Corner, turn: float) -> tuple[Corner, Corner] | None:
    """The part of an edge in directions up to `turn` [rad] from the x axis; None if there is none."""
    cosine, sine = math.cos(turn), math.sin(turn)
    low, high = 0.0, 1.0
    for side in (cosine, -cosine):
        begin, end = sine * first[0] + side * first[1], sine * second[0] + side * second[1]
        if begin < 0 and end < 0:
            return None
        if begin < 0 or end < 0:
            crossing = begin / (begin - end)
            low, high = (max(low, crossing), high) if begin < 0 else (low, min(high, crossing))
    return (_along(first, second, low), _along(first, second, high)) if low <= high else None


def _distance(first: Corner, second: Corner) -> float:
    """Distance of an edge from the origin."""
    across = second[0] - first[0], second[1] - first[1]
    squared = across[0] ** 2 + across[1] ** 2
    share = 0.0 if squared == 0 else -(first[0] * across[0] + first[1] * across[1]) / squared
    return math.hypot(*_along(first, second, max(0.0, min(1.0, share))))


def _along(first: Corner, second: Corner, share: float) -> Corner:
    return first[0] + share * (second[0] - first[0]), first[1] + share * (second[1] - first[1])
