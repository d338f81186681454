"""Covered area: the area of the union of equal discs around the robots, exact up to rounding.

By Green's theorem the area is the integral of (x dy - y dx) / 2 along the boundary of the union. The boundary
consists of those arcs of the circles that no other disc covers. Along the boundary of a hole they run clockwise, so
the area of the hole is not counted.
"""

import math

import numpy as np

from fes.arithmetic import elementary, sums
from fes.arrays.types import Floats, Ints
from world.metrics import graphs
from world.simulation import neighbor_list

TURN = 2.0 * math.pi
"""A full circle [rad]."""


def covered_area(positions: Floats, radius: float) -> float:
    """Area [m^2] within `radius` [m] of at least one of the `positions` [n, 2] [m], all of them finite."""
    centers = np.unique(positions, axis=0)  # robots at one place cover one disc
    near = neighbor_list.measure(np.arange(len(centers)), centers, 2.0 * radius, None)
    rows, peers = near.edges.rows, near.edges.peers
    share = np.minimum(0.5 * near.separation[near.pair] / radius, 1.0)
    half_width = elementary.atan2(np.sqrt((1.0 - share) * (1.0 + share)), share)
    circle, start, end = _visible_arcs(len(centers), *_hidden_arcs(centers, rows, peers, half_width))

    # Each connected region has its own origin: the area does not lose digits far from the world's origin.
    regions = graphs.components(len(centers), rows, peers)
    x, y = (centers - centers[regions])[circle].T
    (first_sine, first_cosine), (last_sine, last_cosine) = elementary.sin_cos(start), elementary.sin_cos(end)
    moment = x * (last_sine - first_sine) - y * (last_cosine - first_cosine)
    return 0.5 * radius * sums.total(radius * (end - start) + moment)


def _hidden_arcs(centers: Floats, rows: Ints, peers: Ints, half_width: Floats) -> tuple[Ints, Floats, Floats]:
    """The arcs of the circles `rows` that the discs of `peers` cover [m]: circle, start in [0, TURN] and end.

    An arc that ends past TURN hides the beginning of its circle too, as a second arc.
    """
    x, y = (centers[peers] - centers[rows]).T
    start = np.mod(elementary.atan2(y, x) - half_width, TURN)
    end = start + 2.0 * half_width
    across = end > TURN
    return (
        np.concatenate([rows, rows[across]]),
        np.concatenate([start, np.zeros(np.count_nonzero(across))]),
        np.concatenate([end, end[across] - TURN]),
    )


def _visible_arcs(n: int, circle: Ints, start: Floats, end: Floats) -> tuple[Ints, Floats, Floats]:
    """The arcs of `n` circles outside all hidden arcs [m]: circle, start and end, start < end."""
    # Two empty arcs per circle, at 0 and at TURN: every visible arc then lies between two hidden ones.
    circles = np.arange(n)
    circle = np.concatenate([circles, circles, circle])
    start = np.concatenate([np.zeros(n), np.full(n, TURN), start])
    end = np.concatenate([np.zeros(n), np.full(n, TURN), end])
    order = np.lexsort((end, start, circle))
    circle, start, end = circle[order], start[order], end[order]

    # The furthest end so far on each circle. The maximum is taken of ranks, and so exactly.
    by_end = np.lexsort((end, circle))
    rank = np.empty_like(by_end)
    rank[by_end] = np.arange(len(by_end))
    furthest = end[by_end[np.maximum.accumulate(rank)]]
    visible = np.flatnonzero(start[1:] > furthest[:-1])  # no circle begins past the end of the one before
    return circle[visible], furthest[visible], start[visible + 1]
