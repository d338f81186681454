"""Bodies that lag and slip, against the differential equation of the lag and the moments of the slip."""

import math

import numpy as np
import pytest

from world.config.starts import RobotsConfig
from world.simulation.hardware import actuators
from world.simulation.hardware.actuators import Actuators

N, DT = 400, 0.02
ALL = np.ones(N, dtype=np.bool_)
COMMANDS = np.tile([2.0, -1.0], (N, 1))


def bodies(lag: float = 0.0, slip: float = 0.0) -> Actuators:
    return Actuators(RobotsConfig(count=N, actuator_lag=lag, slip=slip), 5, DT)


def test_bodies_that_follow_exactly_are_none() -> None:
    assert actuators.of(RobotsConfig(count=N), 5, DT) is None


def test_a_step_command_is_followed_in_first_order_and_covers_its_integral() -> None:
    lagging = bodies(lag=0.2)
    actual, way = lagging.start(), np.zeros((N, 2))
    for tick in range(15):
        held, actual = lagging.step(actual, COMMANDS, tick, ALL)
        way += held * DT
    time = 15 * DT
    assert actual[0] == pytest.approx(COMMANDS[0] * (1.0 - math.exp(-time / 0.2)), rel=1e-12)
    assert way[0] == pytest.approx(COMMANDS[0] * (time - 0.2 * (1.0 - math.exp(-time / 0.2))), rel=1e-12)


def test_slip_is_a_factor_of_each_body_and_a_random_walk() -> None:
    slipping, count = bodies(slip=0.05), 200
    held = np.stack([slipping.step(slipping.start(), COMMANDS, tick, ALL)[0] for tick in range(count)])
    factors = held.mean(axis=0) / COMMANDS
    # the walk of 200 ticks adds .05/sqrt(4 s)/2 to a mean; four standard errors over 400 bodies are 14 %
    expected = [math.hypot(0.05, 0.0125), math.hypot(0.05, 0.025)]
    assert factors.std(axis=0) == pytest.approx(expected, rel=0.142)
    walk = (held - held.mean(axis=0)).std(axis=(0, 1)) * math.sqrt(DT)
    assert walk == pytest.approx([0.05, 0.05], rel=0.015)  # four standard errors of 80,000 numbers, and the mean


def test_an_absent_robot_stands_still_and_begins_again_from_rest() -> None:
    both = bodies(lag=0.2, slip=0.05)
    _, actual = both.step(both.start(), COMMANDS, 0, ALL)
    held, actual = both.step(actual, COMMANDS, 1, ALL & (np.arange(N) != 3))
    assert held[3].tolist() == [0.0, 0.0] == actual[3].tolist()
    assert actual[4, 0] > 0.1
