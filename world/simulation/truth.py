"""Ground truth as pure functions: `step(world, state, twists) -> state`, and the robots' observations of it."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fes.arrays import masks
from fes.arrays.types import Bools, Floats, Ints, read_only
from fes.extension import registry
from fes.extension.kinds import DYNAMICS
from fes.extension.protocols import Dynamics
from fes.model.sensing import DECODED, Observations
from world.config import events
from world.config.events import ParticipationChange
from world.config.faults import Transmission
from world.config.radio import RadioConfig
from world.config.scenario import Scenario, initial_poses
from world.simulation import channel, crowd, neighbor_list, reception
from world.simulation.channel import Medium, Radio, RadioInput
from world.simulation.core import compiled_world
from world.simulation.core.compiled_world import CompiledWorld, Moved
from world.simulation.hardware import actuators, sensors
from world.simulation.hardware.actuators import Actuators
from world.simulation.hardware.sensors import Sensors, SensorState
from world.simulation.neighbor_list import Proximity
from world.simulation.unicycle import Unicycle


@dataclass(frozen=True, eq=False)
class World:
    """The constants of a run."""

    scenario: Scenario
    ids: Ints
    """Robot ids, 0 to n - 1 [n]."""
    medium: Medium
    dynamics: Dynamics[Any]
    changes: dict[int, dict[str, Any]]
    """Tick -> the settings of the channel that change then."""
    participation: dict[int, ParticipationChange]
    """Tick -> the robots that leave and those that rejoin then."""
    transmissions: dict[int, Transmission | None]
    """Tick -> the faults of transmitters from then on."""
    core: CompiledWorld | None
    """The compiled core; None where numpy computes."""
    sensors: Sensors | None
    """None where each robot knows its true pose."""
    actuators: Actuators | None
    """None where bodies follow their commands exactly."""


@dataclass(frozen=True, eq=False)
class State:
    """Everything that is true at one tick."""

    tick: int
    """Number of the tick, from 0."""
    poses: Floats
    """True poses [n, 3] [m, m, rad; world frame]; read-only, as laws and metrics of others see this array."""
    bodies: Any
    """State of the dynamics; for a unicycle the poses themselves."""
    channel: RadioConfig
    """The channel from this tick on, with the fields of `[channel]`. If it is replaced, its `communication_range`
    takes effect a tick later."""
    proximity: Proximity
    """The pairs in range, and those that may soon be."""
    radio: Radio
    """The radio: the pairs in range, and the fate of their beacons."""
    present: Bools
    """True for a robot that takes part [n]. The body of an absent robot stands still and its radio is silent; its
    peers learn of it only by its missing beacons."""
    since: Ints
    """Tick at which each robot last joined [n]."""
    sent: int
    """Beacons sent on open contacts so far."""
    decoded: int
    """Number of those that decoded."""
    transmission: Transmission | None = None
    """The faults of transmitters from this tick on; None while all are healthy."""
    sensing: SensorState | None = None
    """The state of the sensors; None where each robot knows its true pose."""
    actual: Floats | None = None
    """Twists of the bodies [n, 2]; None where they follow their commands exactly."""

    @property
    def decodable(self) -> Bools:
        """True for a robot whose beacon of this tick decodes as a message [n]."""
        return self.present if self.transmission is None else self.present & ~self.transmission.damaged


def create(scenario: Scenario) -> World:
    """The world of a scenario; raises FesError where a channel or the dynamics cannot be created."""
    ids = np.arange(scenario.robots.number)
    context = reception.context(scenario)
    medium = channel.medium(scenario.run.seed, context)
    reception.prepare(scenario.channels, context)
    dynamics = registry.create(DYNAMICS, scenario.robots.dynamics, context)
    schedules = scenario.changes, scenario.participation, scenario.transmissions
    core = compiled_world.of(ids, medium) if type(dynamics) is Unicycle else None
    seed, dt = scenario.run.seed, scenario.run.dt
    hardware = sensors.of(scenario.sensing, seed, len(ids), dt), actuators.of(scenario.robots, seed, dt)
    return World(scenario, ids, medium, dynamics, *schedules, core, *hardware)


@np.errstate(over="ignore", invalid="ignore")
def start(world: World) -> State:
    """The state at tick 0; raises ScenarioError where there is too little memory for all contacts."""
    crowd.check(world.scenario)
    initial, radio = initial_poses(world.scenario), world.scenario.channel
    bodies = world.dynamics.start(initial)
    poses = read_only(world.dynamics.poses(bodies))
    near = neighbor_list.measure(world.ids, poses, radio.communication_range, None)
    present = np.ones(len(poses), dtype=np.bool_)
    state = State(0, poses, bodies, radio, near, channel.quiet(near.edges), present, 0 * world.ids, 0, 0)
    sensing = None if world.sensors is None else world.sensors.start(poses)
    actual = None if world.actuators is None else world.actuators.start()
    return _changed(world, replace(state, sensing=sensing, actual=actual))


def step(world: World, state: State, twists: Floats) -> State:
    """The state one tick later, with the bodies commanded to hold `twists` [n, 2] [m/s, rad/s]; see `held`."""
    actual, sensing = state.actual, state.sensing
    if world.actuators is not None and actual is not None:
        twists, actual = world.actuators.step(actual, twists, state.tick, state.present)
    factor = None if state.transmission is None else state.transmission.reception_factor
    robots = RadioInput(state.tick, state.poses, state.present, state.proximity, factor)
    moved: Moved
    if world.core is not None and world.core.can(state.channel):
        bodies, moved = None, world.core.step(state.channel, robots, state.radio, twists)
    else:
        with np.errstate(over="ignore", invalid="ignore"):  # a robot at infinity is out of range
            bodies = world.dynamics.step(state.bodies, twists, world.scenario.run.dt)
            moved = _moved(world, state, robots, read_only(world.dynamics.poses(bodies)))
    if world.sensors is not None and sensing is not None:
        sensing = world.sensors.step(sensing, state.tick + 1, moved.poses)
    after = State(
        state.tick + 1,
        moved.poses,
        moved.poses if bodies is None else bodies,
        state.channel,
        moved.proximity,
        moved.radio,
        state.present,
        state.since,
        state.sent + moved.sent,
        state.decoded + moved.decoded,
        state.transmission,
        sensing,
        actual,
    )
    return _changed(world, after)


def _moved(world: World, state: State, robots: RadioInput, poses: Floats) -> Moved:
    """The world one tick later with the bodies at `poses` [n, 3]: the definition of the compiled tick."""
    near = neighbor_list.measure(world.ids, poses, state.channel.communication_range, state.proximity)
    radio = channel.transmit(world.medium, state.channel, state.radio, robots, near.edges)
    on_air = radio.reception
    if not masks.is_full(state.present):
        on_air = on_air[channel.among(radio.edges, state.present)]
    sent, decoded = np.count_nonzero(on_air), np.count_nonzero(radio.reception == DECODED)
    return Moved(poses, near, radio, int(sent), int(decoded))


def held(state: State, twists: Floats) -> Floats:
    """The `twists` [n, 2] that bodies execute: that of an absent robot is zero."""
    return twists if masks.is_full(state.present) else np.where(state.present[:, None], twists, 0.0)


def attend(state: State, present: Bools) -> State:
    """The state at the same tick with the robots `present` [n]; the contacts of those that rejoin reopen."""
    back = present & ~state.present
    radio = channel.reopen(state.radio, back) if back.any() else state.radio
    return replace(state, present=present, radio=radio, since=np.where(back, state.tick, state.since))


def observe(state: State) -> Observations:
    """The robots' observations: only what a real robot could sense or receive."""
    held, radio = state.sensing and state.sensing.held, state.radio
    if held is None:
        return Observations(state.tick, state.poses, radio.edges, radio.reception)
    return Observations(state.tick, held.poses, radio.edges, radio.reception, held.ticks)


def _changed(world: World, state: State) -> State:
    """The state after the scheduled changes of its tick: to participation, transmitters and the channel."""
    planned, settings = world.participation.get(state.tick), world.changes.get(state.tick)
    if planned is not None:
        state = attend(state, events.participating(state.present, planned))
    if state.tick in world.transmissions:
        state = replace(state, transmission=world.transmissions[state.tick])
    if settings is None:
        return state
    return replace(state, channel=events.changed(state.channel, settings, world.scenario.run.dt))
