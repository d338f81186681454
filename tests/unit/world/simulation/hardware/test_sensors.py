"""Fixes: how much they err, when they are measured, and when they arrive."""

import math
from typing import Any

import numpy as np
import pytest

from fes.arrays.types import Floats
from world.config.starts import SensingConfig
from world.simulation.hardware import sensors
from world.simulation.hardware.sensors import Fixes, Sensors

N, DT = 40, 0.02


def sensing(**settings: Any) -> Sensors:
    return Sensors(SensingConfig(**settings), 3, N, DT)


def truth(tick: int) -> Floats:
    """Robots that drive along x with 1 m per tick."""
    return np.stack([np.full(N, float(tick)), np.arange(N, dtype=np.float64), np.full(N, 0.1)], axis=1)


def held(which: Sensors, ticks: int) -> list[Fixes]:
    """The fixes that the robots have at each tick."""
    state = which.start(truth(0))
    fixes = [state.held]
    for tick in range(1, ticks):
        state = which.step(state, tick, truth(tick))
        fixes.append(state.held)
    return fixes


def test_sensors_that_do_not_err_are_none() -> None:
    assert sensors.of(SensingConfig(), 3, N, DT) is None
    assert sensors.of(SensingConfig(pose_rate=50.0), 3, N, DT) is not None


def test_a_fix_errs_by_the_noise_of_each_axis() -> None:
    fixes = held(sensing(pose_noise=2.0, heading_noise=0.1), 200)
    errors = np.stack([fix.poses - truth(tick) for tick, fix in enumerate(fixes)])
    # 8,000 numbers: four standard errors of a standard deviation, 3.2 %
    assert errors.std(axis=(0, 1)) == pytest.approx([2.0, 2.0, 0.1], rel=0.032)
    assert all((fix.ticks == tick).all() for tick, fix in enumerate(fixes))


def test_drift_has_its_deviation_from_the_start_and_its_correlation_time() -> None:
    fixes = held(sensing(pose_drift=2.0, pose_drift_time=1.0), 1001)
    errors = np.stack([fix.poses - truth(tick) for tick, fix in enumerate(fixes)])[:, :, :2]
    assert errors[0].std() == pytest.approx(2.0, rel=0.32)  # 80 numbers, four standard errors
    # 80 axes over 20 s: 800 independent numbers
    assert errors.std() == pytest.approx(2.0, rel=0.1)
    later = (errors[50:] * errors[:-50]).mean() / (errors**2).mean()  # one correlation time later
    assert later == pytest.approx(math.exp(-1.0), abs=0.15)
    assert not (errors[1:] == errors[:-1]).any()


@pytest.mark.parametrize("rate", [1.0, 7.0, 30.0])
def test_robots_measure_at_their_rate_one_after_the_other_and_hold_a_fix_between(rate: float) -> None:
    fixes = held(sensing(pose_rate=rate), 501)
    ticks = np.stack([fix.ticks for fix in fixes])
    changes = np.diff(ticks, axis=0) > 0
    assert np.abs(changes.sum(axis=0) - 10.0 * rate).max() <= 1.0
    assert (np.diff(ticks, axis=0)[changes] <= 50.0 / rate + 1.0)[N:].all()
    assert changes.sum(axis=1).max() < N  # staggered
    for tick, fix in enumerate(fixes):
        assert (fix.poses[:, 0] == fix.ticks).all()
        assert (fix.ticks <= tick).all()


def test_a_fix_arrives_after_its_latency_and_before_that_robots_have_the_one_of_tick_zero() -> None:
    fixes = held(sensing(pose_latency=0.06), 20)
    assert [fix.ticks[0] for fix in fixes] == [max(0, tick - 3) for tick in range(20)]
    assert [fix.poses[0, 0] for fix in fixes] == [max(0, tick - 3) for tick in range(20)]


def test_rate_and_latency_change_no_error() -> None:
    noise = {"pose_noise": 1.0, "heading_noise": 0.1, "pose_drift": 0.5}
    every = held(sensing(**noise), 120)
    for others in ({"pose_rate": 7.0}, {"pose_latency": 0.1}, {"pose_rate": 20.0, "pose_latency": 0.04}):
        for fix in held(sensing(**noise, **others), 120):
            expected = [every[tick].poses[robot].tolist() for robot, tick in enumerate(fix.ticks.tolist())]
            assert fix.poses.tolist() == expected


def test_a_heading_stays_an_angle() -> None:
    headings = np.stack([fix.poses[:, 2] for fix in held(sensing(heading_noise=3.0), 50)])
    assert np.abs(headings).max() <= math.pi
