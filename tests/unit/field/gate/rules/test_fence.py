"""Fences: points inside and outside of polygons."""

import math

from hypothesis import given
from hypothesis import strategies as st

from field.gate.rules.fence import braking_problem, is_clear, is_inside
from tests.support.gates import settings

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


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-7.0, 7.0), st.floats(0.01, 2.0), st.floats(0.0, 2.0))
def test_a_border_within_reach_is_noticed_in_each_direction_that_counts(
    x: float, y: float, heading: float, reach: float, turn: float
) -> None:
    corners = ((-2.0, -2.0), (2.0, -2.0), (0.5, 0.0), (2.0, 2.0), (-2.0, 2.0))
    if not is_inside(corners, x, y):
        return
    most = turn if turn < math.pi / 2 else math.pi
    angles = [heading + most * share / 50 for share in range(-50, 51)]
    ends = [(x + reach * math.cos(angle), y + reach * math.sin(angle)) for angle in angles]
    if is_clear(corners, (x, y, heading), reach, turn):
        assert all(is_inside(corners, *end) for end in ends)
    else:
        # the sector slightly enlarged is then not clear of the border
        wider = [heading + (most + 0.05) * share / 50 for share in range(-50, 51)]
        lengths = [reach * share / 40 * 1.05 for share in range(1, 41)]
        sector = [(x + far * math.cos(angle), y + far * math.sin(angle)) for angle in wider for far in lengths]
        near = [point for point in sector if not is_inside(corners, *point)]
        assert near or _to_corner(corners, x, y) <= 1.05 * reach


def _to_corner(corners: tuple[tuple[float, float], ...], x: float, y: float) -> float:
    """Distance to the next corner: a sampled sector can miss the tip of a notch."""
    return min(math.dist(corner, (x, y)) for corner in corners)


def test_only_the_border_ahead_is_in_the_way() -> None:
    square = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    assert not is_clear(square, (0.9, 0.5, 0.0), 0.11, 0.0)
    assert is_clear(square, (0.9, 0.5, 0.0), 0.09, 0.0)
    assert is_clear(square, (0.9, 0.5, math.pi / 2), 0.2, 0.5)  # 0.1 m / sin 0.5 is 0.21 m
    assert not is_clear(square, (0.9, 0.5, math.pi / 2), 0.3, 1.3)
    assert not is_clear(square, (0.9, 0.5, math.pi), 0.11, 2.0)  # every direction


def test_a_robot_may_get_a_twist_only_if_it_can_brake_before_the_fence() -> None:
    corners = ((-9.0, -9.0), (1.0, -9.0), (1.0, 9.0), (-9.0, 9.0))
    chosen = settings(fence=corners)  # 0.2 m/s: v²/2a is 0.04 m, and v L is 0.2 · 0.06 = 0.012 m
    assert braking_problem(chosen, (0.947, 0.0, 0.0), (0.2, 0.0)) == ""
    expected = "the fence is within the braking distance, 0.05 m: 0.95, 0.00 m"
    assert braking_problem(chosen, (0.949, 0.0, 0.0), (0.2, 0.0)) == expected
    assert braking_problem(chosen, (0.949, 0.0, 0.0), (0.1, 0.0)) == ""
    assert braking_problem(chosen, (0.949, 0.0, 0.0), (-0.2, 0.0)) == ""
    assert braking_problem(chosen, (0.949, 0.0, math.pi), (-0.2, 0.0)) == expected
    assert braking_problem(settings(), (5e9, 0.0, 0.0), (0.2, 0.0)) == ""
