"""The unicycle (5) on its exact arc, against a numerical integration of its differential equation."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.arrays import geometry
from fes.model import kinematics
from tests.support import reference as witness

angles = st.floats(-math.pi, math.pi)


def integrated(pose: list[float], linear: float, angular: float, dt: float) -> list[float]:
    """The pose after dt of x' = v cos(theta), y' = v sin(theta), theta' = omega."""
    after = witness.flow(
        lambda t, x: (linear * math.cos(x[2]), linear * math.sin(x[2]), angular), pose, 0.0, dt, 1e-12
    )
    return [float(value) for value in after]


def turned(a: float, b: float) -> float:
    """The angle between two headings, unsigned [rad]."""
    return abs(math.remainder(a - b, 2.0 * math.pi))


@pytest.mark.parametrize("dt", [0.02, 0.5])
@pytest.mark.parametrize("angular", [0.0, 1e-12, 1e-5, 0.3, -2.0, 20.0, 384.0, -384.0])
def test_a_held_twist_moves_a_robot_as_its_differential_equation_does(angular: float, dt: float) -> None:
    rng = np.random.default_rng(3)
    poses = np.column_stack([rng.uniform(-200, 200, (5, 2)), rng.uniform(-math.pi, math.pi, 5)])
    linear = rng.uniform(-40.0, 40.0, 5)
    moved = kinematics.move(poses, np.column_stack([linear, np.full(5, angular)]), dt)
    for before, speed, after in zip(poses.tolist(), linear.tolist(), moved.tolist(), strict=True):
        x, y, heading = integrated(before, speed, angular, dt)
        assert math.hypot(after[0] - x, after[1] - y) < 1e-9  # m; the integrator's error over 200 m
        assert turned(after[2], heading) < 1e-10  # rad; its error, and the rounding of 192 rad


def test_a_full_circle_ends_where_it_began() -> None:
    pose = np.array([[3.0, -4.0, 1.0]])
    moved = kinematics.move(pose, np.array([[5.0, math.pi]]), 2.0)
    np.testing.assert_allclose(moved, pose, atol=1e-14)  # sin(pi) is 1.2e-16, times 10 m


def test_a_quarter_circle_ends_where_elementary_geometry_says() -> None:
    # radius v/omega = 2 m, counter-clockwise from (0, 0) along +x: ends at (2, 2), looking along +y
    moved = kinematics.move(np.zeros((1, 3)), np.array([[math.pi, math.pi / 2]]), 1.0)
    np.testing.assert_allclose(moved, [[2.0, 2.0, math.pi / 2]], atol=1e-14)  # a few roundings


def test_moving_does_not_change_the_previous_poses() -> None:
    poses = np.array([[1.0, 2.0, 3.0]])
    kinematics.move(poses, np.array([[4.0, 5.0]]), 0.1)
    assert poses.tolist() == [[1.0, 2.0, 3.0]]


@given(heading=angles, angular=st.floats(-400.0, 400.0))
def test_headings_stay_wrapped(heading: float, angular: float) -> None:
    moved = kinematics.move(np.array([[0.0, 0.0, heading]]), np.array([[0.0, angular]]), 0.05)
    assert -math.pi <= moved[0, 2] <= math.pi
    assert turned(moved[0, 2], heading + 0.05 * angular) < 1e-14  # rad; roundings of 20 rad


@given(angle=st.floats(-1e3, 1e3))
def test_wrap_changes_an_angle_by_full_turns_only(angle: float) -> None:
    wrapped = float(geometry.wrap(np.array([angle]))[0])
    assert -math.pi <= wrapped <= math.pi
    assert turned(wrapped, angle) < 1e-12  # rad; roundings of 1e3 rad


@given(a=st.tuples(angles, angles), b=st.tuples(angles, angles))
def test_separation_is_the_same_to_the_bit_from_either_end(a: tuple[float, float], b: tuple[float, float]) -> None:
    forth, back = (geometry.separation(np.array([p[0] - q[0]]), np.array([p[1] - q[1]])) for p, q in ((a, b), (b, a)))
    assert forth.tolist() == back.tolist()
    # abs: below 1e-154 the squares underflow
    assert float(forth[0]) == pytest.approx(math.dist(a, b), rel=1e-15, abs=1e-150)
