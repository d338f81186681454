"""Ground truth as pure functions: `step(world, state, twists) -> state`, and what the robots sense of it."""

from dataclasses import dataclass, replace

import numpy as np

from fes import draws
from fes.arrays import Floats, Ints
from fes.sensing import DECODED, Observations
from world import channel, kinematics, proximity
from world.channel import Draws, Radio
from world.proximity import Proximity
from world.scenario import Scenario, initial_poses


@dataclass(frozen=True, eq=False)
class World:
    """What does not change during a run."""

    scenario: Scenario
    ids: Ints
    """Robot ids, 0 to n - 1 [n]."""
    draws: Draws


@dataclass(frozen=True, eq=False)
class State:
    """Everything that is true at one tick."""

    tick: int
    poses: Floats
    """[n, 3] [m, m, rad; world frame]"""
    proximity: Proximity
    radio: Radio
    sent: int
    """Beacons sent on open contacts so far."""
    decoded: int
    """Of them, decoded."""


def create(scenario: Scenario) -> World:
    """The world of a scenario."""
    ids = np.arange(scenario.robots.number)
    return World(scenario, ids, Draws(draws.key(scenario.run.seed, "channel")))


def start(world: World) -> State:
    """The state at tick 0."""
    poses = initial_poses(world.scenario)
    near = proximity.measure(world.ids, poses, world.scenario.channel.communication_range, None)
    return State(0, poses, near, channel.quiet(near.edges), 0, 0)


def step(world: World, state: State, twists: Floats) -> State:
    """The state one tick later, the robots holding `twists` [n, 2] [m/s, rad/s]."""
    config = world.scenario.channel
    poses = kinematics.move(state.poses, twists, world.scenario.run.dt)
    near = proximity.measure(world.ids, poses, config.communication_range, state.proximity)
    radio = channel.transmit(state.radio, state.tick, state.proximity, near, config, world.draws)
    return replace(
        state,
        tick=state.tick + 1,
        poses=poses,
        proximity=near,
        radio=radio,
        sent=state.sent + int(np.count_nonzero(radio.reception)),
        decoded=state.decoded + int(np.count_nonzero(radio.reception == DECODED)),
    )


def observe(state: State) -> Observations:
    """What the robots sense: nothing that a real robot could not sense or receive."""
    return Observations(state.tick, state.poses, state.radio.edges, state.radio.reception)
