"""The tick from which a real robot takes part."""

from fes.protocol.robot_control import HELD, RUNNING, STOPPED
from field.runtime.participation import LONGEST_GAP, Participation

PERIOD = 20_000_000


def test_a_robot_takes_part_from_its_first_tick_with_a_pose_and_a_started_gate() -> None:
    participation = Participation()
    assert participation.step(7, 7 * PERIOD, "", 0) is None
    assert participation.step(8, 8 * PERIOD, STOPPED, 0) is None
    assert participation.step(9, 9 * PERIOD, RUNNING, None) is None
    assert participation.step(10, 10 * PERIOD, RUNNING, 0) == 10
    assert participation.step(11, 11 * PERIOD, RUNNING, 0) == 10


def test_a_held_robot_goes_on_to_count_beacons() -> None:
    participation = Participation()
    participation.step(0, 0, RUNNING, 0)
    assert participation.step(1, PERIOD, HELD, LONGEST_GAP) == 0


def test_a_robot_that_was_stopped_starts_anew() -> None:
    participation = Participation()
    participation.step(0, 0, RUNNING, 0)
    assert participation.step(1, PERIOD, STOPPED, 0) is None
    assert participation.step(2, 2 * PERIOD, RUNNING, 0) == 2


def test_a_robot_without_a_pose_for_too_long_starts_anew_when_it_has_one() -> None:
    participation = Participation()
    participation.step(0, 0, RUNNING, 0)
    assert participation.step(1, PERIOD, HELD, LONGEST_GAP + 1) is None
    assert participation.step(2, 2 * PERIOD, RUNNING, 0) == 2


def test_a_suspended_robot_starts_anew() -> None:
    participation = Participation()
    participation.step(0, 0, RUNNING, 0)
    assert participation.step(60, LONGEST_GAP, RUNNING, 0) == 0
    assert participation.step(200, 2 * LONGEST_GAP + 1, RUNNING, 0) == 200
