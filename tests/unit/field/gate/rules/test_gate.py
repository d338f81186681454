"""Each rule of the gate by hand."""

import math

import pytest

from fes.protocol.robot_control import HELD, RUNNING, STOPPED, Start
from field.gate.rules import gate as rules
from field.gate.rules.settings import Placement
from tests.support.gates import PERIOD, ROUNDING, Rig, running, settings


def settle(rig: Rig, seconds: float = 1.0) -> None:
    """Ticks with poses and permits, and without commands."""
    for _ in range(round(seconds / PERIOD)):
        rig.permit()
        rig.see()
        rig.tick()


def test_a_started_robot_follows_commands() -> None:
    rig = running(0.1)
    assert rig.status.mode == RUNNING
    assert rig.gate.twist == pytest.approx((0.1, 0.0))


def test_a_robot_that_is_not_started_stands_and_publishes_nothing() -> None:
    rig = Rig()
    rig.run(1.0, 0.1)
    assert rig.gate.twist == (0.0, 0.0)
    assert not rig.gate.is_started
    assert rig.status.mode == STOPPED
    assert rig.status.reason == "not started"


@pytest.mark.parametrize(
    ("missing", "rule"), [("permit", "permit"), ("pose", "pose"), ("frame", "frame"), ("rival", "another program")]
)
def test_a_start_is_refused_without_permit_pose_frame_or_with_a_second_driver(missing: str, rule: str) -> None:
    rig = Rig()
    if missing != "permit":
        rig.permit()
    if missing != "pose":
        rig.see("odom" if missing == "frame" else "map")
    if missing == "rival":
        rig.gate = rules.rivaled(rig.gate, rig.now, "cmd_vel")
    assert rule in rig.start()
    rig.run(1.0, 0.1)
    assert rig.gate.twist == (0.0, 0.0)


@pytest.mark.parametrize("age", [1.01, 3600.0, -0.01])
def test_a_start_that_the_network_held_up_or_of_another_clock_is_refused(age: float) -> None:
    rig = Rig()
    rig.permit()
    rig.see()
    assert rig.start(age) == "the start took more than 1 s to arrive"
    assert rig.gate.latch
    assert rig.start(0.99) == ""


def test_a_start_for_the_gate_before_is_refused() -> None:
    rig, before = Rig(), Rig()
    rig.permit()
    rig.see()
    rig.gate = rig.gate._replace(zero=rig.gate.zero + 10**15)  # another random number
    _, refusal = rules.started(rig.gate, rig.settings, rig.now, Start(before.status.clock))
    assert "to arrive" in refusal


def test_a_start_outside_the_fence_is_refused_until_the_robot_is_carried_inside() -> None:
    rig = Rig(settings(fence=((-1.0, -1.0), (1.0, -1.0), (0.0, 1.0))))
    rig.permit()
    rig.see(shift=5.0)
    assert "outside the fence: 5.00, 0.00 m" in rig.start()
    rig.see()
    assert rig.start() == ""


def test_a_second_start_changes_nothing() -> None:
    rig = running()
    before = rig.gate
    assert rig.start() == ""
    assert rig.gate == before


def test_a_command_computed_before_the_start_never_moves_the_robot() -> None:
    rig = Rig()
    rig.permit()
    rig.see()
    assert rig.start() == ""
    rig.now += 0.01
    rig.command(0.1, age=0.02)
    rig.tick()
    assert rig.gate.wanted == (0.0, 0.0)
    rig.command(0.1, age=0.02)
    assert rig.gate.wanted == (0.1, 0.0)


@pytest.mark.parametrize("age", [0.11, 1.0, -0.01])
def test_a_command_that_is_old_or_from_the_future_is_refused(age: float) -> None:
    rig = running(0.1)
    before = rig.status
    rig.command(-0.1, age=age)
    assert rig.gate.wanted == (0.1, 0.0)
    assert rig.status.refused == before.refused + 1
    assert rig.status.accepted == before.accepted


@pytest.mark.parametrize("step", [0, -1, -10])
def test_a_repeated_or_reordered_command_is_refused(step: int) -> None:
    rig = running(0.1)
    rig.command(-0.1, step=step)
    assert rig.gate.wanted == (0.1, 0.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_refused(bad: float) -> None:
    rig = running(0.1)
    rig.command(bad)
    rig.command(0.0, bad)
    assert rig.gate.wanted == (0.1, 0.0)


def test_commands_are_clipped_to_the_limits_of_the_body() -> None:
    rig = running(0.1)
    rig.run(1.0, 50.0, -500.0)
    assert rig.gate.twist == (0.2, -3.0)


def test_commands_are_scaled_and_the_state_is_told_at_full_size() -> None:
    rig = running(5.0, settings(placement=Placement(scale=100.0)))
    assert rig.gate.twist == pytest.approx((0.05, 0.0))
    assert rig.status.twist == pytest.approx((5.0, 0.0))
    assert rig.status.pose[0] == pytest.approx(100 * rig.pose[0], abs=0.5)


def test_the_robot_stands_after_the_timeout_and_its_braking_time_when_the_agent_hangs() -> None:
    rig = running(0.2)
    rig.run(1.0, 0.2)
    since, start = rig.now, rig.pose[0]
    limits, timing = rig.settings.limits, rig.settings.timing
    while rig.gate.twist != (0.0, 0.0):
        rig.permit()
        rig.see()
        rig.tick()
    assert rig.now - since <= timing.timeout + limits.linear / limits.acceleration + 2 * PERIOD + ROUNDING
    bound = 0.2**2 / (2 * limits.acceleration) + 0.2 * (timing.timeout + 2 * PERIOD)
    assert 0 < rig.pose[0] - start <= bound
    assert (rig.status.mode, rig.status.reason) == (HELD, "no command from the agent for 0.25 s")
    rig.run(0.5, 0.1)
    assert rig.status.mode == RUNNING


def test_a_burst_of_queued_commands_leaves_only_the_young_ones() -> None:
    rig = running(0.1)
    settle(rig)
    before = rig.status.accepted
    for age in range(150, 0, -2):  # 3 s of commands, 0.02 to 1.5 s old
        rig.command(-0.2, age=age / 100)
    assert rig.status.accepted - before == 5  # 0.1, 0.08, ... 0.02 s
