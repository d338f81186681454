"""Body frame and team frame."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from field.gate.rules import frames
from field.gate.rules.settings import Placement

meters = st.floats(-50.0, 50.0)
angles = st.floats(-3.0, 3.0)


def test_a_pose_is_turned_then_moved_then_scaled() -> None:
    placement = Placement(scale=10.0, x=1.0, y=2.0, heading=math.pi / 2)
    assert frames.to_team(placement, 3.0, 0.5, 0.1) == pytest.approx((5.0, 50.0, 0.1 + math.pi / 2))


@given(meters, meters, angles, meters, meters, angles, st.floats(0.1, 200.0))
def test_a_step_ahead_of_the_body_is_a_step_ahead_in_the_team_frame(
    x: float, y: float, heading: float, origin_x: float, origin_y: float, turn: float, scale: float
) -> None:
    placement = Placement(scale, origin_x, origin_y, turn)
    first = frames.to_team(placement, x, y, heading)
    second = frames.to_team(placement, x + 0.5 * math.cos(heading), y + 0.5 * math.sin(heading), heading)
    step = second[0] - first[0], second[1] - first[1]
    assert math.hypot(*step) == pytest.approx(0.5 * scale)
    assert math.cos(math.atan2(step[1], step[0]) - first[2]) == pytest.approx(1.0)


@given(angles, st.integers(-5, 5))
def test_whole_turns_do_not_change_a_heading(angle: float, turns: int) -> None:
    assert frames.wrapped(angle + 2 * math.pi * turns) == pytest.approx(angle)


def test_a_twist_is_scaled_in_its_linear_part_only() -> None:
    placement = Placement(scale=100.0, heading=1.0)
    assert frames.to_body_twist(placement, 5.0, 2.0) == (0.05, 2.0)
    assert frames.to_team_twist(placement, 0.05, 2.0) == (5.0, 2.0)
