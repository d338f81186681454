"""The pose at a tick, from poses at times of their own."""

import math

import pytest

from field.runtime.fixes import Fix, Fixes, Pose

PERIOD = 20_000_000
FORWARD, CIRCLE = (2.0, 0.0), (2.0, math.pi)


def known(*times: int) -> Fixes:
    """Fixes whose pose at each of the `times` has it as its x [us]."""
    fixes = Fixes(PERIOD)
    for time in times:
        fixes.add(Pose(time, (time * 1e-3, 0.0, 0.0)))
    return fixes


def test_before_the_first_pose_no_fix_is_known() -> None:
    assert Fixes(PERIOD).fix(5, 5 * PERIOD, FORWARD) is None
    assert known(5 * PERIOD + 1).fix(5, 5 * PERIOD, FORWARD) is None
    assert Fixes(PERIOD).age(7) is None


def test_a_pose_of_the_very_begin_of_the_tick_is_not_changed() -> None:
    assert known(5 * PERIOD).fix(5, 5 * PERIOD, CIRCLE) == Fix((5 * PERIOD * 1e-3, 0.0, 0.0), 5)


def test_a_young_pose_is_moved_to_the_begin_of_this_tick() -> None:
    time = 5 * PERIOD - PERIOD // 2
    fix = known(time).fix(5, 5 * PERIOD, FORWARD)
    assert fix is not None
    assert fix.tick == 5
    assert fix.pose == pytest.approx((time * 1e-3 + 0.02, 0.0, 0.0))


def test_an_old_pose_is_moved_to_the_nearest_tick_which_it_names() -> None:
    time = 5 * PERIOD + PERIOD // 4
    fix = known(time).fix(8, 8 * PERIOD, FORWARD)
    assert fix is not None
    assert fix.tick == 5
    assert fix.pose == pytest.approx((time * 1e-3 - 0.01, 0.0, 0.0))


def test_a_pose_that_came_after_the_tick_is_for_a_later_one() -> None:
    fix = known(4 * PERIOD, 5 * PERIOD + 1).fix(5, 5 * PERIOD, (0.0, 0.0))
    assert fix == Fix((4 * PERIOD * 1e-3, 0.0, 0.0), 4)


def test_the_heading_turns_with_the_twist() -> None:
    fix = known(5 * PERIOD - PERIOD // 2).fix(5, 5 * PERIOD, CIRCLE)
    assert fix is not None
    assert fix.pose[2] == pytest.approx(0.01 * math.pi)
