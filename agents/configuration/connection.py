"""Check that robots on straight paths stay connected.

All robots shrink their errors at one common rate, so each difference of two positions moves on a straight segment. A
norm is convex: a pair within reach at both ends of a piece of the path is within reach on all of it.
"""

import numpy as np

from fes.arrays import geometry
from fes.arrays.types import Floats
from fes.shapes import routes

PIECES = 10
"""Pieces of the path that are checked one by one. A check in one piece is too strict for crowded starts."""

MARGIN = 0.01
"""Margin of the reach over the longest link that the team needs at the start [m]."""


def reach(distance: Floats, keep_range: float) -> float:
    """The separation up to which a plan counts on a link [m], by the `distance` [n, n] of robots at the start.

    It is `keep_range`, or more where the team at the start needs a longer link to be connected.
    """
    return max(keep_range, bottleneck(distance) + MARGIN)


def bottleneck(distance: Floats) -> float:
    """The longest edge of the minimum spanning tree of `distance` [n, n] [m], after Prim; 0 for one robot."""
    longest, nearest = 0.0, distance[0].copy()
    is_outside = np.ones(len(distance), dtype=np.bool_)
    is_outside[0] = False
    for _ in range(len(distance) - 1):
        outside = np.where(is_outside, nearest, np.inf)
        joined = int(outside.argmin())
        longest = max(longest, float(outside[joined]))
        is_outside[joined] = False
        np.minimum(nearest, distance[joined], out=nearest)
    return longest


def is_kept(start: Floats, end: Floats, reach: float) -> bool:
    """True if robots that go straight from `start` to `end` [n, 2] [m] stay connected within `reach` [m]."""
    share = (np.arange(PIECES + 1) / PIECES)[:, None, None]
    is_near = geometry.distances(start + share * (end - start)) <= reach
    return bool(routes.reaches_all(is_near[:-1] & is_near[1:]).all())
