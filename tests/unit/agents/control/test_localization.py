"""Dead reckoning with scalar gains, against hand calculation and a second implementation for one robot."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.control import localization
from agents.control.localization import Localizer, Located
from fes.arrays.types import Floats
from fes.model.config import AgentConfig, FormationConfig, LocalizationConfig, ObjectiveConfig, SensorConfig
from fes.model.seeking import OracleConfig
from fes.model.sensing import Sensed
from tests.support.dead_reckoning import OneRobot

DT = 0.02


def localizer(noise: float = 1.0, heading: float = 0.1, lag: float = 0.0, **others: Any) -> Localizer:
    """The localization of robots that are told this noise [m, rad] and lag [s]."""
    config = AgentConfig(
        dt=DT,
        seed=1,
        objective=ObjectiveConfig(),
        seeking=OracleConfig(),
        formation=FormationConfig(),
        channel=None,
        sensors=SensorConfig(pose_noise=noise, heading_noise=heading, actuator_lag=lag),
        localization=LocalizationConfig(**others),
    )
    return localization.of(config)


def sensed(tick: int, *fixes: tuple[float, float, float], fixed: list[int] | None = None) -> Sensed:
    return Sensed(tick, np.array(fixes, dtype=np.float64), None if fixed is None else np.array(fixed))


def after(robot: Localizer, fixes: list[tuple[float, float, float]], twist: tuple[float, float]) -> list[Located]:
    """The states of one robot with a fix at each tick, which holds one twist."""
    states, located = [], localization.start(1)
    for tick, fix in enumerate(fixes):
        located = localization.locate(robot, located, sensed(tick, fix))
        states.append(located)
        located = localization.command(located, np.array([twist]))
    return states


def test_four_fixes_give_the_poses_and_variances_of_a_hand_calculation() -> None:
    fixes = [(1.0, 0.0, 0.1), (2.0, 0.0, 0.2), (0.0, 0.0, 0.0), (4.0, 0.0, 0.4)]
    states = after(localizer(), fixes, (1.0, 0.5))
    poses = np.array([state.poses[0] for state in states])
    variances = np.array([state.variance[0] for state in states])
    # abs: the table has eight decimals
    assert poses[:, 0] == pytest.approx([1.0, 1.51014083, 1.01924314, 1.78140593], abs=1e-8)
    assert poses[:, 1] == pytest.approx([0.0, 0.00104765, 0.00282665, 0.00381515], abs=1e-8)
    assert poses[:, 2] == pytest.approx([0.1, 0.155445545, 0.1084924, 0.19365259], abs=1e-8)
    assert variances[:, 0] == pytest.approx([1.0, 0.50019992, 0.33377745, 0.25069916], abs=1e-8)
    assert variances[:, 1] == pytest.approx([0.01, 0.00504951, 0.00344241, 0.00266992], abs=1e-8)


@pytest.mark.parametrize(
    ("noise", "heading", "every", "column", "gain"),
    [
        (1.0, 0.1, 1, 0, 0.02789),
        (1.0, 0.1, 5, 0, 0.06128),
        (1.0, 0.1, 50, 0, 0.18100),
        (0.3, 0.1, 1, 0, 0.08994),
        (0.1, 0.1, 1, 0, 0.24566),
        (1.0, math.radians(5.0), 1, 1, 0.14946),
        (1.0, math.radians(5.0), 5, 1, 0.30261),
        (1.0, math.radians(5.0), 50, 1, 0.66412),
        (1.0, math.radians(1.0), 1, 1, 0.54598),
    ],
)
def test_the_gain_falls_to_the_solution_of_its_riccati_equation(
    noise: float, heading: float, every: int, column: int, gain: float
) -> None:
    # K = (sqrt(L^2 + 4 L) - L) / 2 with L = q^2 T / sigma^2; after a fix P = K sigma^2
    robot, located = localizer(noise, heading), localization.start(1)
    for tick in range(max(600, 80 * every)):
        fix = tick - tick % every
        located = localization.locate(robot, located, sensed(tick, (0.0, 0.0, 0.0), fixed=[fix]))
        if fix == tick:
            variance = located.variance[0, column]
    assert variance / robot.noise[column] == pytest.approx(gain, abs=1e-5)  # the table has five decimals


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    noise=st.sampled_from([0.05, 1.0]),
    lag=st.sampled_from([0.0, 0.2]),
    most_late=st.integers(0, 60),
)
def test_two_implementations_agree_over_missed_and_late_fixes_jumps_and_lags(
    seed: int, noise: float, lag: float, most_late: int
) -> None:
    random = np.random.default_rng(seed)
    robot, located, witness = localizer(noise, 0.1, lag), localization.start(1), OneRobot(noise, 0.1, lag, DT)
    jump, fixed, fix = 0.0, 0, (0.0, 0.0, 0.0)
    for tick in range(150):
        if random.random() < 0.6:
            fixed = max(fixed, tick - int(random.integers(0, most_late + 1)))
            jump += 12.0 * (random.random() < 0.02)
            fix = (jump + noise * random.normal(), noise * random.normal(), random.uniform(-3.1, 3.1))
        located = localization.locate(robot, located, sensed(tick, fix, fixed=[fixed]))
        witness.step(tick, fix, fixed)
        twist = (float(random.uniform(-5.0, 5.0)), float(random.uniform(-3.0, 3.0)))
        located, witness.twist = localization.command(located, np.array([twist])), twist
        ours, theirs = located.poses[0], witness.pose
        # 150 ticks of some roundings of 50 m, and the witness's quotient by a small turn
        assert ours[:2] == pytest.approx(theirs[:2], abs=1e-9)
        assert abs(math.remainder(ours[2] - theirs[2], 2.0 * math.pi)) < 1e-9
        assert located.variance[0] == pytest.approx(witness.variance, rel=1e-9)


def test_exact_fixes_of_each_tick_are_the_array_itself() -> None:
    robot, located = localizer(0.0, 0.0), localization.start(2)
    for tick in range(3):
        given_ = sensed(tick, (1e3 * tick, 2.0, 3.0), (0.1, 0.2, 0.3))
        located = localization.locate(robot, located, given_)
        assert located.poses is given_.poses
        located = localization.command(located, np.array([[1.0, 0.5], [2.0, -0.5]]))


def test_an_exact_fix_is_the_pose_to_the_bit_also_beside_a_robot_whose_fix_is_old() -> None:
    robot, located = localizer(0.0, 0.0), localization.start(2)
    for tick in range(4):
        fixes = ((0.1 * tick, 0.3, 0.7), (5.0, 5.0, 5.0))
        located = localization.locate(robot, located, sensed(tick, *fixes, fixed=[tick, 0]))
        assert tuple(located.poses[0]) == fixes[0]
        located = localization.command(located, np.array([[1.0, 0.5], [1.0, 0.0]]))
    # the other one has moved along its heading for three ticks
    assert located.poses[1, 0] == pytest.approx(5.0 + 0.06 * math.cos(5.0), rel=1e-12)


def test_without_the_filter_a_pose_is_the_fix_however_old() -> None:
    robot = localizer(1.0, 0.1, filter="none")
    given_ = sensed(9, (1.0, 2.0, 3.0), fixed=[2])
    assert localization.locate(robot, localization.start(1), given_).poses is given_.poses


def jumped(robot: Localizer, fixes: list[Floats], fixed: list[int] | None = None) -> list[float]:
    """x of a robot that stood at the origin for a second, at each of the `fixes` since."""
    located = localization.start(1)
    for tick in range(50):
        located = localization.locate(robot, located, sensed(tick, (0.0, 0.0, 0.0)))
    places = []
    for number, fix in enumerate(fixes):
        measured = None if fixed is None else [50 + fixed[number]]
        located = localization.locate(robot, located, sensed(50 + number, tuple(fix), fixed=measured))
        places.append(float(located.poses[0, 0]))
    return places


def test_a_robot_that_was_moved_is_located_anew_at_the_fifth_fix_from_there() -> None:
    places = jumped(localizer(0.1), [np.array([10.0, 0.0, 0.0])] * 6)
    assert places == [0.0, 0.0, 0.0, 0.0, 10.0, 10.0]


def test_a_single_far_fix_is_ignored_and_so_is_its_heading() -> None:
    robot, located = localizer(0.1), localization.start(1)
    for tick in range(100):
        fix = (20.0, 0.0, 1.0) if tick == 60 else (0.0, 0.0, 0.0)
        located = localization.locate(robot, located, sensed(tick, fix))
        assert located.poses.tolist() == [[0.0, 0.0, 0.0]]


def test_a_far_fix_that_is_held_counts_once() -> None:
    places = jumped(localizer(0.1), [np.array([10.0, 0.0, 0.0])] * 9, fixed=[0, 0, 0, 0, 0, 0, 0, 1, 2])
    assert places == [0.0] * 9


def test_a_late_fix_corrects_the_pose_by_the_difference_at_its_own_tick() -> None:
    """A robot that drives at 5 m/s, and whose fixes are right but 0.1 s old, stays where it is."""
    robot, located = localizer(0.03, 0.02), localization.start(1)
    for tick in range(200):
        measured = max(0, tick - 5)
        located = localization.locate(robot, located, sensed(tick, (0.1 * measured, 0.0, 0.0), fixed=[measured]))
        located = localization.command(located, np.array([[5.0, 0.0]]))
        assert located.poses[0] == pytest.approx([0.1 * tick, 0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_the_digits_of_a_robot_do_not_depend_on_the_other_robots_of_its_process(noise: float) -> None:
    random, n = np.random.default_rng(7), 4
    robot, together = localizer(noise, 0.1 * noise), localization.start(n)
    alone = [localization.start(1) for _ in range(n)]
    fixed = np.zeros(n, dtype=np.int64)
    for tick in range(200):
        due = random.random(n) < 0.5
        fixed = np.where(due, np.maximum(fixed, tick - random.integers(0, 7, n)), fixed)
        fixes, twists = random.normal(size=(n, 3)), random.normal(size=(n, 2))
        if tick % 40 == 30:
            restarted = random.random(n) < 0.5
            together = localization.forget(together, restarted)
            alone = [localization.forget(one, restarted[k : k + 1]) for k, one in enumerate(alone)]
        together = localization.locate(robot, together, Sensed(tick, fixes, fixed))
        for k in range(n):
            row = slice(k, k + 1)
            one = localization.locate(robot, alone[k], Sensed(tick, fixes[row], fixed[row]))
            assert one.poses.tobytes() == together.poses[row].tobytes()
            assert one.variance.tobytes() == together.variance[row].tobytes()
            alone[k] = localization.command(one, twists[row])
        together = localization.command(together, twists)


def test_a_robot_predicts_over_all_ticks_that_it_skipped_with_the_command_that_it_held() -> None:
    located = after(localizer(), [(0.0, 0.0, 0.0)], (2.0, 0.0))[0]
    located = localization.command(located, np.array([[2.0, 0.0]]))
    skipped = localization.locate(localizer(), located, sensed(10, (0.0, 0.0, 0.0), fixed=[0]))
    assert skipped.poses[0] == pytest.approx([0.4, 0.0, 0.0], rel=1e-12)


@pytest.mark.parametrize("tick", [3, 2**52])
def test_a_robot_that_missed_a_second_or_a_world_that_went_back_starts_anew(tick: int) -> None:
    located = localization.locate(localizer(), localization.start(1), sensed(1000, (0.0, 0.0, 0.0)))
    anew = localization.locate(localizer(), located, sensed(tick, (7.0, 8.0, 0.5)))
    assert anew.poses.tolist() == [[7.0, 8.0, 0.5]]
    assert anew.variance[0] == pytest.approx([1.0, 0.01])


def test_poses_as_large_as_floats_do_no_harm_to_other_robots() -> None:
    robot, located = localizer(), localization.start(2)
    for tick in range(4):
        fixes = (1.7e308 * (-1.0) ** tick, 0.0, 0.0), (0.0, 0.0, 0.0)
        located = localization.locate(robot, located, sensed(tick, *fixes))
    assert located.poses[1].tolist() == [0.0, 0.0, 0.0]
