"""Ten thousand random histories: no order of events lets the gate break its bounds."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fes.protocol.robot_control import RUNNING, STOPPED
from field.gate.rules import gate as rules
from field.gate.rules.settings import Limits
from tests.support.gates import PERIOD, ROUNDING, Rig
from tests.support.gates import settings as gate_settings

FENCE = ((-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0))
SETTINGS = gate_settings(fence=FENCE, silence=0.5, limits=Limits(angular_acceleration=12.0))
VALUES = (0.05, -0.2, 0.15, 7.0, -1e300, math.inf, math.nan, 0.0)


class Watch:
    """A rig, and what an onlooker knows without the gate's own state."""

    def __init__(self) -> None:
        self.rig = Rig(SETTINGS)
        self.usable: list[float] = []
        """Times of computation of commands that were young and finite when they arrived."""
        self.quiet_for = 0.0
        """Time of the gate's ticks since the last of them was computed [s]."""
        self.cut = -math.inf
        """Last moment at which the robot was stopped or held by anything but an absent command."""
        self.moved = False

    def command(self, value: int, age: float) -> None:
        linear, angular = VALUES[value % 8], VALUES[(5 * value + value // 8) % 8]
        rig, is_repeated = self.rig, value % 31 == 3 and self.rig.gate.sequence == self.rig.sequence
        wanted = rig.gate.wanted
        rig.command(linear, angular, age, step=0 if is_repeated else 1, heard=0.6 if value % 13 == 12 else 0.0)
        if is_repeated:
            assert rig.gate.wanted == wanted
        elif math.isfinite(linear + angular) and 0 <= rig.now - (rig.now - age) <= 0.1:
            self.usable.append(rig.now - age)
            self.quiet_for = max(0.0, min(self.quiet_for, age))

    def tick(self, dt: float, late: float) -> None:
        rig, limits = self.rig, SETTINGS.limits
        before = rig.gate.twist
        rig.tick(dt, late)
        step = min(dt, PERIOD + SETTINGS.timing.lateness)
        self.quiet_for += step
        self.check(before, step, limits)

    def check(self, before: tuple[float, float], step: float, limits: Limits) -> None:
        rig = self.rig
        linear, angular = rig.gate.twist
        assert math.isfinite(linear + angular)
        assert abs(linear) <= limits.linear
        assert abs(angular) <= limits.angular
        assert abs(linear - before[0]) <= limits.acceleration * step + ROUNDING
        assert abs(angular - before[1]) <= limits.angular_acceleration * step + ROUNDING
        most = limits.linear / limits.acceleration, limits.angular / limits.angular_acceleration
        if self.quiet_for > SETTINGS.timing.timeout + max(most) + 2 * PERIOD:
            assert (linear, angular) == (0.0, 0.0)
        speeds_up = abs(linear) > abs(before[0]) or abs(angular) > abs(before[1])
        if speeds_up:
            self.moved = True
            recent = [time for time in self.usable if rig.now - time <= SETTINGS.timing.timeout]
            assert [time for time in recent if time > self.cut]
        status = rig.status
        if status.mode != RUNNING and not status.reason.startswith("no command"):
            assert not speeds_up
            self.cut = rig.now


def play(actions: bytes) -> Watch:
    """One history: each byte is an event."""
    watch = Watch()
    rig = watch.rig
    rig.permit()
    rig.see()
    for action in actions:
        kind, value = action % 16, action // 16
        if kind == 0:
            was_stopped = rig.status.mode == STOPPED
            if not rig.start() and was_stopped:
                watch.cut = rig.now
        elif kind <= 6:
            rig.permit()
            rig.see()
            watch.command(value, age=0.002 * value)
            watch.tick(PERIOD, 0.0)
        elif kind == 7:
            watch.command(value * 17, age=(-0.05, 0.0, 0.05, 0.1, 0.12, 0.3, 1.0, 3.0)[value % 8])
        elif kind == 8:
            for _ in range(value):
                watch.tick(PERIOD, 0.0)
        elif kind == 9:
            watch.tick(PERIOD + 0.02 * value, 0.02 * value)
        elif kind == 10:
            rig.see("map" if value % 4 else "odom", shift=0.01 * value if value % 5 else 1.0)
        elif kind == 11:
            rig.gate = rules.stopped(rig.gate, "stopped by the operator")
        elif kind == 12 and value < 4:
            rig.gate = rules.rivaled(rig.gate, rig.now, "cmd_vel")
        elif kind == 13:
            rig.permit(operator=value, number=value)
        elif kind == 14:
            rig.see(stamp=rig.stamp - value)
        else:
            for _ in range(value):
                rig.permit()
                rig.see()
                watch.command(value, age=0.0)
                watch.tick(PERIOD, 0.0)
    return watch


@pytest.mark.slow
def test_no_history_breaks_a_bound_of_the_gate() -> None:
    moved = []

    @settings(max_examples=10_000, suppress_health_check=[HealthCheck.too_slow], database=None)
    @given(st.booleans(), st.binary(max_size=24))
    def all_bounds_hold(begins_started: bool, actions: bytes) -> None:
        moved.append(play(b"\0" * begins_started + actions).moved)

    all_bounds_hold()
    assert len(moved) >= 10_000
    assert sum(moved) > 2000  # so that the bounds were put to the test


def test_the_histories_notice_a_command_from_before_the_start() -> None:
    watch = Watch()
    watch.rig.permit()
    watch.rig.see()
    assert watch.rig.start() == ""
    watch.rig.gate = watch.rig.gate._replace(wanted=(0.2, 0.0), computed_at=watch.rig.now, heard_at=watch.rig.now)
    watch.cut = watch.rig.now
    with pytest.raises(AssertionError):
        watch.tick(PERIOD, 0.0)
