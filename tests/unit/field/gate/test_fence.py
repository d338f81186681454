"""Fences: points inside and outside of polygons."""

import math

from hypothesis import given
from hypothesis import strategies as st

from field.gate.pose_guard import is_inside

numbers = st.floats(-3.0, 3.0)


@given(numbers, numbers, st.integers(3, 12), st.booleans())
def test_a_point_is_inside_a_regular_polygon_as_its_edges_say(x: float, y: float, sides: int, reverse: bool) -> None:
    corners = [
        (2 * math.cos(2 * math.pi * side / sides), 2 * math.sin(2 * math.pi * side / sides)) for side in range(sides)
    ]
    apothem = 2 * math.cos(math.pi / sides)
    depths = [
        apothem - x * math.cos(angle) - y * math.sin(angle)
        for angle in (2 * math.pi * (side + 0.5) / sides for side in range(sides))
    ]
    if min(map(abs, depths)) > 1e-9:  # on the border either may hold
        assert is_inside(corners[::-1] if reverse else corners, x, y) == (min(depths) > 0)


def test_a_notch_of_a_concave_fence_is_outside() -> None:
    fence = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0))
    assert is_inside(fence, 0.5, 2.0)
    assert is_inside(fence, 3.5, 2.0)
    assert not is_inside(fence, 2.0, 2.0)


def test_a_point_at_the_height_of_a_corner_is_judged_once() -> None:
    fence = ((0.0, 0.0), (2.0, 1.0), (0.0, 2.0))
    assert is_inside(fence, 0.5, 1.0)
    assert not is_inside(fence, -0.5, 1.0)
    assert not is_inside(fence, 2.5, 1.0)


def test_without_a_fence_every_point_is_inside() -> None:
    assert is_inside((), 1e9, -1e9)
