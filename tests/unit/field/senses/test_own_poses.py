"""Own poses between steps."""

import math

import pytest

from field.senses.own_poses import TICKS, OwnPoses


def test_between_two_steps_the_pose_is_linear_and_the_heading_turns_the_shorter_way() -> None:
    poses = OwnPoses()
    poses.add(4, (1.0, 2.0, math.pi - 0.1))
    poses.add(6, (2.0, 4.0, -math.pi + 0.3))
    assert poses.between(5.0) == pytest.approx((1.5, 3.0, -math.pi + 0.1))
    assert poses.between(4.25) == pytest.approx((1.125, 2.25, math.pi - 0.05))


def test_outside_of_the_steps_the_pose_is_the_nearest_one() -> None:
    poses = OwnPoses()
    for tick in range(2 * TICKS):
        poses.add(tick, (float(tick), 0.0, 0.0))
    assert poses.between(2.0 * TICKS + 5.0)[0] == 2 * TICKS - 1
    assert poses.between(-5.0)[0] == TICKS
    assert [poses.between(float(tick))[0] for tick in range(TICKS, 2 * TICKS)] == list(range(TICKS, 2 * TICKS))


def test_before_the_first_step_no_pose_is_known() -> None:
    with pytest.raises(LookupError):
        OwnPoses().between(0.0)
