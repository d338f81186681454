"""The compiled world repeats numpy's to the bit, for all motions of robots and all changes of the channel."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fes.arrays.types import Floats
from tests.support import bits, cores
from world.config.faults import Transmission
from world.config.scenario import Scenario, parse
from world.simulation import truth
from world.simulation.core import compiled_world
from world.simulation.formula import Formula
from world.simulation.truth import State

pytestmark = cores.needs(compiled_world.load())

CHANNELS: dict[str, dict[str, Any]] = {
    "rayleigh": {},
    "exponent 2.7": {"path_loss_exponent": 2.7},
    "exponent 3.5": {"path_loss_exponent": 3.5, "reference_snr": 1e6},
    "logistic": {"model": "logistic"},
    "perfect": {"model": "perfect"},
}
UNKNOWN: dict[str, dict[str, Any]] = {
    "shadowing": {"shadowing": {"deviation": 6.0, "decorrelation_distance": 15.0}},
    "bursts": {"bursts": {"bad_share": 0.1, "mean_length": 0.2, "loss": 0.9}},
    "jammer": {"jammers": [{"x": 10.0, "y": -20.0, "radius": 30.0}]},
    "partition": {"partition": [[0, 1], [2, 3]]},
    "table": {"model": "table", "rows": [[10, 1.0], [90, 0.53], [170, 0.01]]},
}
"""Channels that the core lacks."""
TEAMS = {1: 30, 2: 60, 10: 100, 64: 30, 65: 40, 300: 25}
"""Ticks by number of robots: more than 64 have a list of candidates."""


class Subclass(Formula):
    """A channel of somebody else."""

    def probability(self, separation: Floats) -> Floats:
        return np.full_like(separation, 0.5)


def scenario(robots: int, seed: int = 0, **channel: Any) -> Scenario:
    generator = np.random.default_rng(seed)
    width = 60.0 * np.sqrt(robots)
    poses = np.stack([*generator.uniform(0.0, width, (2, robots)), generator.uniform(-4.0, 4.0, robots)], axis=1)
    tables = {"schema": 1, "run": {"seed": seed + 4}, "robots": {"poses": poses.tolist()}}
    return parse({**tables, "channel": channel, "seeking": {"index": "measured"}}, "here")


class Pair:
    """A world that the core moves, beside the same world moved by numpy."""

    def __init__(self, of: Scenario) -> None:
        self.core = truth.create(of)
        self.numpy = replace(truth.create(of), core=None)
        self.state, self.expected = truth.start(self.core), truth.start(self.numpy)
        self.ticks = 0

    def step(self, twists: Floats) -> None:
        self.ticks += self.core.core is not None and self.core.core.can(self.state.channel)
        self.state = truth.step(self.core, self.state, twists)
        self.expected = truth.step(self.numpy, self.expected, twists)
        assert not bits.differences(self.state, self.expected), self.state.tick

    def change(self, change: Callable[[State], State]) -> None:
        self.state, self.expected = change(self.state), change(self.expected)


def twists(generator: np.random.Generator, robots: int) -> Floats:
    """Twists of all magnitudes: robots come in range and leave, stand, and turn many times in a tick."""
    values = generator.normal(0.0, 1.0, (robots, 2)) * generator.choice([0.0, 0.1, 5.0, 500.0], (robots, 1))
    return np.where(generator.random((robots, 2)) < 0.02, generator.choice([1e9, -1e9, -0.0], (robots, 2)), values)


@pytest.mark.parametrize("channel", CHANNELS)
@pytest.mark.parametrize("robots", TEAMS)
def test_robots_that_drive_anywhere_give_the_same_world(robots: int, channel: str) -> None:
    pair, generator = Pair(scenario(robots, **CHANNELS[channel])), np.random.default_rng(robots)
    for _ in range(TEAMS[robots]):
        pair.step(twists(generator, robots))
    assert pair.ticks == TEAMS[robots]


@pytest.mark.parametrize("channel", CHANNELS)
@pytest.mark.parametrize("robots", [10, 70])
def test_robots_that_stay_together_give_the_same_radio(robots: int, channel: str) -> None:
    pair, generator = Pair(scenario(robots, **CHANNELS[channel])), np.random.default_rng(1)
    for _ in range(60):
        pair.step(generator.normal(0.0, 4.0, (robots, 2)))
    assert pair.state.sent > 1000


@pytest.mark.parametrize("channel", CHANNELS)
def test_participation_and_faults_of_transmitters_change_both_alike(channel: str) -> None:
    robots, generator = 12, np.random.default_rng(2)
    pair = Pair(scenario(robots, **CHANNELS[channel]))
    for tick in range(200):
        if tick % 7 == 3:
            present = generator.random(robots) < 0.8
            pair.change(lambda state, present=present: truth.attend(state, present))  # type: ignore[misc]
        if tick % 11 == 5:
            factor = generator.choice([1.0, 0.5, 0.0], robots)
            faults = None if tick % 3 == 0 else Transmission(factor, factor == 0.0)
            pair.change(lambda state, faults=faults: replace(state, transmission=faults))  # type: ignore[misc]
        pair.step(truth.held(pair.state, generator.normal(0.0, 4.0, (robots, 2))))
    assert pair.ticks == 200


@pytest.mark.parametrize("unknown", UNKNOWN)
@pytest.mark.parametrize("robots", [10, 70])
def test_a_channel_that_the_core_lacks_is_numpys_and_the_core_resumes_after_it(robots: int, unknown: str) -> None:
    channels = [scenario(robots, **channel).channel for channel in (*CHANNELS.values(), UNKNOWN[unknown])]
    channels += [scenario(robots, communication_range=reach).channel for reach in (80.0, 250.0)]
    pair, generator = Pair(scenario(robots)), np.random.default_rng(3)
    for tick in range(72):
        if tick % 6 == 5:
            channel = channels[-3] if tick % 12 == 5 else channels[int(generator.integers(len(channels)))]
            pair.change(lambda state, channel=channel: replace(state, channel=channel))  # type: ignore[misc]
        pair.step(generator.normal(0.0, 8.0, (robots, 2)))
    assert 15 < pair.ticks < 55


@pytest.mark.parametrize("robots", [3, 64, 70])
def test_robots_at_infinity_and_beyond_the_floats_are_out_of_range_in_both(robots: int) -> None:
    pair, generator = Pair(scenario(robots)), np.random.default_rng(4)
    for tick in range(30):
        values = generator.normal(0.0, 4.0, (robots, 2))
        if tick in (5, 20):
            values[tick % robots, 0] = np.inf if tick == 5 else -1e308
        if tick == 10 and robots <= 64:  # numpy's search of candidates takes no NaN
            values[1, 1] = np.nan
        pair.step(values)
    assert not np.isfinite(pair.state.poses).all()


def test_two_histories_of_one_world_do_not_disturb_each_other() -> None:
    of = scenario(12)
    first, second = Pair(of), Pair(of)
    second.core = first.core
    generator = np.random.default_rng(5)
    for tick in range(60):
        (first, second)[tick % 2].step(generator.normal(0.0, 4.0, (12, 2)))
    earlier = first.state
    for _ in range(10):
        first.step(np.zeros((12, 2)))
    first.state = first.expected = earlier
    first.step(np.ones((12, 2)))


def test_a_channel_of_somebody_else_is_numpys_also_where_its_class_is_derived_from_a_built_in_one() -> None:
    world = truth.create(scenario(3))
    assert world.core is not None
    known, other = scenario(3).channel, scenario(3).channel
    assert world.core.can(known)
    world.medium.reception.of = lambda config: Subclass(config, None)  # type: ignore[method-assign,arg-type]
    assert not world.core.can(other)
