"""The polygon that a robot must not leave."""

from collections.abc import Sequence
from itertools import pairwise

Corner = tuple[float, float]


def is_inside(fence: Sequence[Corner], x: float, y: float) -> bool:
    """True if a point lies in a polygon, or there is no polygon; either may hold on its border.

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
