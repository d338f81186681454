"""The check of the motion: real bodies pass, mistakes of units and frames are detected."""

import math
import random
from collections.abc import Callable

import pytest

from field.gate.rules import motion
from field.gate.rules.frames import Pose, Twist
from field.gate.rules.motion import Motion
from field.gate.rules.settings import Limits

LIMITS = Limits()
WINDOW = 2.0
DT = 0.02

Drive = Callable[[float], Twist]
"""The commanded twist at a time."""


def straight(time: float) -> Twist:
    return 0.15, 0.0


def weaving(time: float) -> Twist:
    return 0.15, 2.5 * math.copysign(1.0, math.sin(2 * math.pi * time / 1.5))


def circling(time: float) -> Twist:
    return 0.15, 1.5


def turning(time: float) -> Twist:
    return 0.0, 2.0


def crawling(time: float) -> Twist:
    return 0.01, 0.1


def first_problem(drive: Drive, seen_as: Callable[[Pose], Pose], lag: float = 0.0, gains: Twist = (1.0, 1.0)) -> str:
    """The first problem within 8 s of a body with a first-order lag [s], whose poses `seen_as` shows."""
    state, twist, pose = Motion(), (0.0, 0.0), (0.0, 0.0, 0.0)
    for step in range(400):
        commanded = drive(step * DT)
        share = DT / (lag + DT)
        twist = (
            twist[0] + share * (gains[0] * commanded[0] - twist[0]),
            twist[1] + share * (gains[1] * commanded[1] - twist[1]),
        )
        x, y, heading = pose
        pose = (
            x + twist[0] * DT * math.cos(heading + twist[1] * DT / 2),
            y + twist[0] * DT * math.sin(heading + twist[1] * DT / 2),
            heading + twist[1] * DT,
        )
        state = motion.updated(state, WINDOW, step * DT, commanded, seen_as(pose))
        if problem := motion.problem(state, WINDOW, LIMITS):
            assert step * DT <= WINDOW + 0.5  # and a part, if the body was slow at first
            return problem
    return ""


def identity(pose: Pose) -> Pose:
    return pose


@pytest.mark.parametrize("drive", [straight, weaving, circling, turning, crawling])
@pytest.mark.parametrize("lag", [0.0, 0.03, 0.15, 0.3])
def test_a_body_with_a_lag_passes(drive: Drive, lag: float) -> None:
    assert first_problem(drive, identity, lag) == ""


@pytest.mark.parametrize("gains", [(0.6, 0.53), (1.4, 1.2)])
def test_a_body_that_slips_passes(gains: Twist) -> None:
    assert first_problem(weaving, identity, 0.1, gains) == ""


def test_a_noisy_pose_passes() -> None:
    source = random.Random(5)
    assert (
        first_problem(
            weaving,
            lambda pose: (pose[0] + source.gauss(0, 0.003), pose[1] + source.gauss(0, 0.003), pose[2]),
            0.1,
        )
        == ""
    )


MISTAKES: dict[str, tuple[Callable[[Pose], Pose], Drive]] = {
    "a body that stands": (lambda pose: (0.0, 0.0, 0.0), straight),
    "millimeters": (lambda pose: (1000 * pose[0], 1000 * pose[1], pose[2]), straight),
    "a reversed axis": (lambda pose: (-pose[0], -pose[1], pose[2]), straight),
    "a heading from another axis": (lambda pose: (pose[0], pose[1], pose[2] + math.pi / 2), straight),
    "clockwise headings": (lambda pose: (pose[0], -pose[1], -pose[2]), circling),
    "clockwise headings, turning": (lambda pose: (pose[0], -pose[1], -pose[2]), turning),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_of_units_or_frames_is_detected_within_its_window(mistake: str) -> None:
    seen_as, drive = MISTAKES[mistake]
    assert "times as far as commanded within 2 s" in first_problem(drive, seen_as)


def test_a_crawling_body_is_not_judged() -> None:
    assert first_problem(crawling, lambda pose: (0.0, 0.0, 0.0)) == ""
