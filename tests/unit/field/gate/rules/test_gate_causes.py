"""Causes that stop or hold the robot, each by hand."""

from collections.abc import Callable

import pytest

from fes.protocol.robot_control import HELD, RUNNING, STOPPED
from field.gate.rules import gate as rules
from field.gate.rules.settings import Placement
from tests.support.gates import PERIOD, Rig, running, settings

CAUSES: dict[str, Callable[[Rig], None]] = {
    "operator": lambda rig: setattr(rig, "gate", rules.stopped(rig.gate, "stopped by the operator")),
    "fence": lambda rig: rig.see(shift=0.05),
    "frame": lambda rig: rig.see("odom"),
    "type": lambda rig: setattr(rig, "gate", rules.faulted(rig.gate, "no pose")),
    "jump": lambda rig: rig.see(shift=-0.5),
    "rival": lambda rig: setattr(rig, "gate", rules.rivaled(rig.gate, rig.now, "cmd_vel")),
}
NEAR_FENCE = ((-10.0, -10.0), (0.12, -10.0), (0.12, 10.0), (-10.0, 10.0))
"""The rig has travelled about 0.09 m when it runs."""


@pytest.mark.parametrize("cause", CAUSES)
def test_a_stop_is_latched_and_only_a_start_releases_it(cause: str) -> None:
    rig = running(0.1, settings(fence=NEAR_FENCE))
    CAUSES[cause](rig)
    reason = rig.status.reason
    assert rig.status.mode == STOPPED
    rig.run(1.0, 0.1)
    assert rig.gate.twist == (0.0, 0.0)
    assert (rig.status.mode, rig.status.reason) == (STOPPED, reason)
    rig.now += 2.0
    rig.permit()
    rig.see()
    assert rig.start() == ""
    rig.run(0.2, -0.1)
    assert rig.status.mode == RUNNING
    assert rig.gate.twist[0] < 0


def test_a_pose_out_of_range_stops_the_robot_and_is_not_shown() -> None:
    rig = running(0.1, settings(placement=Placement(scale=100.0)))
    before = rig.status.pose
    rig.see(shift=1e307)
    assert (rig.status.mode, rig.status.reason) == (STOPPED, "the pose and its twist must be finite at full size")
    assert rig.status.pose == before
    assert rig.start() == rig.status.reason


def test_a_lapsed_permit_stops_the_robot_and_a_new_one_does_not_release_it() -> None:
    rig = running(0.1)
    for _ in range(52):
        rig.see()
        rig.command(0.1)
        rig.tick()
    assert rig.status.reason == "the operator's permit has lapsed"
    rig.run(1.0, 0.1)
    assert rig.status.mode == STOPPED
    assert rig.gate.twist == (0.0, 0.0)


def test_repeated_permits_do_not_renew_the_permission() -> None:
    rig = running(0.1)
    number = rig.permit_number
    for _ in range(52):
        rig.permit(number=number)
        rig.see()
        rig.command(0.1)
        rig.tick()
    assert rig.status.mode == STOPPED


def test_permits_of_a_second_operator_count_when_those_of_the_first_have_lapsed() -> None:
    rig = Rig()
    rig.permit(operator=1)
    rig.permit(operator=2)
    assert rig.gate.permits.operator == 1
    rig.now += 1.5
    rig.permit(operator=2)
    assert rig.gate.permits.operator == 2


@pytest.mark.parametrize("reason", ["pose", "stamp", "loop"])
def test_a_hold_ends_with_its_cause(reason: str) -> None:
    rig = running(0.1)
    stamp = rig.stamp
    for _ in range(40):
        rig.permit()
        rig.command(0.1)
        if reason == "stamp":
            rig.see(stamp=stamp)
        if reason == "loop":
            rig.see()
        rig.tick(late=0.05 if reason == "loop" else 0.0)
    assert rig.status.mode == HELD
    assert {"pose": "pose", "stamp": "pose", "loop": "late by 50 ms"}[reason] in rig.status.reason
    assert rig.gate.twist == (0.0, 0.0)
    rig.run(0.5, 0.1)
    assert rig.status.mode == RUNNING
    assert rig.gate.twist == pytest.approx((0.1, 0.0))


def test_a_command_computed_while_the_loop_was_late_does_not_move_the_robot() -> None:
    rig = running(0.1)
    rig.tick(dt=0.1, late=0.08)
    rig.see()
    rig.command(0.1, age=0.03)  # young, but older than the end of the hold
    rig.now += 0.01
    rig.command(0.1, age=0.02)
    assert rig.gate.wanted == (0.0, 0.0)
    rig.now += 0.02
    rig.command(0.1, age=0.02)
    assert rig.gate.wanted == (0.1, 0.0)


def test_stamps_that_go_back_hold_a_running_robot_but_not_a_stopped_one() -> None:
    rig = running(0.1)
    rig.stamp = 5
    rig.run(0.5, 0.1)
    assert rig.status.mode == HELD
    rig.gate = rules.stopped(rig.gate, "stopped by the operator")
    rig.see()
    assert rig.start() == ""


def test_a_driver_without_a_clock_is_accepted() -> None:
    rig = running(0.1)
    for _ in range(50):
        rig.permit()
        rig.see(stamp=0)
        rig.command(0.1)
        rig.tick()
    assert rig.status.mode == RUNNING


def test_a_robot_without_peers_is_held_only_if_a_silence_is_set() -> None:
    for silence, mode in ((2.0, HELD), (None, RUNNING)):
        rig = running(0.1, settings(silence=silence))
        for step in range(125):
            rig.permit()
            rig.see()
            rig.command(0.1, heard=step * PERIOD)
            rig.tick()
        assert rig.status.mode == mode


def test_a_slow_pose_and_late_arrivals_are_not_a_jump() -> None:
    rig = running(0.2)
    rig.run(1.0, 0.2)
    for step in range(60):
        rig.permit()
        rig.command(0.2)
        if step % 7 == 0:
            rig.see()
            rig.see()  # two at once
        rig.tick()
    assert rig.status.mode == RUNNING


def test_a_body_that_does_not_move_as_commanded_stops_within_three_seconds() -> None:
    rig = running(0.2)
    rig.slip = 0.0, 1.0
    rig.run(3.0, 0.2)
    assert rig.status.mode == STOPPED
    assert rig.status.reason.startswith("the pose travels 0.3 times as far as commanded")
