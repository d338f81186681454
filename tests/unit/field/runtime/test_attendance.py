"""When a real robot takes part, and from which tick."""

from fes.protocol.robot_control import HELD, RUNNING, STOPPED
from field.runtime.attendance import LONGEST_GAP, Attendance

PERIOD = 20_000_000


def test_a_robot_takes_part_from_its_first_tick_with_a_pose_and_a_started_gate() -> None:
    attendance = Attendance()
    assert attendance.step(7, 7 * PERIOD, "", 0) is None
    assert attendance.step(8, 8 * PERIOD, STOPPED, 0) is None
    assert attendance.step(9, 9 * PERIOD, RUNNING, None) is None
    assert attendance.step(10, 10 * PERIOD, RUNNING, 0) == 10
    assert attendance.step(11, 11 * PERIOD, RUNNING, 0) == 10


def test_a_held_robot_goes_on_to_count_beacons() -> None:
    attendance = Attendance()
    attendance.step(0, 0, RUNNING, 0)
    assert attendance.step(1, PERIOD, HELD, LONGEST_GAP) == 0


def test_a_robot_that_was_stopped_starts_anew() -> None:
    attendance = Attendance()
    attendance.step(0, 0, RUNNING, 0)
    assert attendance.step(1, PERIOD, STOPPED, 0) is None
    assert attendance.step(2, 2 * PERIOD, RUNNING, 0) == 2


def test_a_robot_without_a_pose_for_too_long_starts_anew_when_it_has_one() -> None:
    attendance = Attendance()
    attendance.step(0, 0, RUNNING, 0)
    assert attendance.step(1, PERIOD, HELD, LONGEST_GAP + 1) is None
    assert attendance.step(2, 2 * PERIOD, RUNNING, 0) == 2


def test_a_suspended_robot_starts_anew() -> None:
    attendance = Attendance()
    attendance.step(0, 0, RUNNING, 0)
    assert attendance.step(60, LONGEST_GAP, RUNNING, 0) == 0
    assert attendance.step(200, 2 * LONGEST_GAP + 1, RUNNING, 0) == 200
