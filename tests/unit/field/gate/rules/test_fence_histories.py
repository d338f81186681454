"""Ten thousand random drives: a robot brakes before its fence, and never crosses it."""

import math
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from field.gate.rules import fence
from field.gate.rules.settings import Limits, Placement
from tests.support.gates import PERIOD, Rig
from tests.support.gates import settings as gate_settings

FENCES = (
    ((-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)),
    ((-0.4, -0.3), (0.5, -0.3), (0.1, 0.0), (0.5, 0.4), (-0.4, 0.2)),  # a notch ahead
)
LIMITS = Limits(acceleration=0.25, angular_acceleration=12.0)
"""The braking distance is 8 cm: a check of the pose alone would let the robot leave."""

LINEAR = (0.2, 0.2, -0.2, 0.1, 0.2, -0.1, 0.2, 0.2)
ANGULAR = (0.0, 1.0, 0.0, -3.0, 3.0, -1.0, 0.3, -0.3)


class Drive:
    """A rig behind a fence, and its true pose at all times."""

    def __init__(self, corners: tuple[fence.Corner, ...], pose: tuple[float, float, float], scale: float) -> None:
        full = tuple((scale * x, scale * y) for x, y in corners)
        parts = gate_settings(fence=full, placement=Placement(scale=scale))
        self.rig = Rig(replace(parts, limits=LIMITS))
        self.rig.pose = list(pose)
        self.corners = corners
        self.stops = 0

    def start(self) -> None:
        """A start by the operator, at any time."""
        self.rig.permit()
        self.rig.see()
        self.rig.start()

    def tick(self, linear: float, angular: float, late: float, *, sees: bool) -> None:
        """A command, perhaps a pose, and a turn of the gate's loop, which may be late."""
        rig = self.rig
        rig.permit()
        if sees:
            rig.see()
        rig.command(rig.settings.placement.scale * linear, angular)
        was_stopped = rig.gate.latch
        rig.tick(PERIOD + late, late)
        x, y, _ = rig.pose
        assert fence.is_inside(self.corners, x, y)
        self.stops += not was_stopped and "braking distance" in rig.gate.latch


def play(drive: Drive, actions: bytes) -> None:
    """One history: each byte is a command for up to 0.6 s, or a start."""
    drive.start()
    for action in actions:
        kind, value = action % 8, action // 8
        if kind == 7:
            drive.start()
        for step in range(4 + value % 4 * 8):
            late = 0.01 * (value % 5) if kind in (4, 5) and step % 3 == 0 else 0.0
            sees = kind in (0, 1, 2, 7) or step % (2 + value % 7) == 0
            drive.tick(LINEAR[kind], ANGULAR[(value // 4 + kind) % 8], late, sees=sees)


@pytest.mark.slow
def test_no_drive_crosses_the_fence() -> None:
    stops = []
    xs, ys, angles = st.floats(-0.25, 0.05), st.floats(-0.2, 0.15), st.floats(-3.2, 3.2)

    @settings(max_examples=10_000, suppress_health_check=[HealthCheck.too_slow], database=None)
    @given(
        st.sampled_from(FENCES),
        st.tuples(xs, ys, angles),
        st.sampled_from((1.0, 100.0)),
        st.binary(max_size=5),
    )
    def stays_inside(
        corners: tuple[fence.Corner, ...], pose: tuple[float, float, float], scale: float, actions: bytes
    ) -> None:
        drive = Drive(corners, pose, scale)
        play(drive, actions)
        stops.append(drive.stops)

    stays_inside()
    assert len(stops) >= 10_000
    assert sum(map(bool, stops)) > 500  # so that the fence was put to the test


def test_the_drives_notice_a_robot_that_rolls_over_its_fence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fence, "braking_problem", lambda *parts: "")
    drive = Drive(FENCES[0], (0.0, 0.0, 0.0), 1.0)
    with pytest.raises(AssertionError):
        play(drive, bytes([8 * 3] * 5))


def test_a_robot_that_stands_before_its_fence_may_drive_along_it_and_away() -> None:
    for heading, is_free in ((0.0, False), (math.pi / 2, True), (math.pi, True)):
        drive = Drive(FENCES[0], (0.29, 0.0, heading), 1.0)
        drive.start()
        for _ in range(40):
            drive.tick(0.1, 0.0, 0.0, sees=True)
        assert (drive.stops == 0) is is_free
