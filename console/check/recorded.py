"""A recorded run, and its world or some of its robots executed again from the recorded messages.

A second execution compares each message with the recorded one, to the byte.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from agents.control import crew
from agents.control.state import Crew, CrewState
from agents.runtime import marshalling as agent_marshalling
from agents.runtime.marshalling import MessageAssembler
from agents.runtime.reception import Receiver
from console.backends import inprocess
from console.replay import difference
from console.replay.difference import Difference
from fes.protocol import messages
from fes.protocol.messages import Observation
from fes.recording.layout import TickPayloads
from world.config.scenario import Scenario, agent_config
from world.execution import marshalling as world_marshalling
from world.execution.marshalling import CommandBatch
from world.metrics.collector import MetricsCollector
from world.simulation import truth
from world.simulation.truth import World

Numbers = dict[str, dict[str, float | None]]
"""The results of all metrics, by name."""

MakeCrew = Callable[[Crew], Crew]
MakeWorld = Callable[[World, MetricsCollector], tuple[World, MetricsCollector]]
Pause = Callable[[Any], Any]
"""Replaces a state between two ticks, for example by a copy of it."""


class Moment(NamedTuple):
    """One recorded tick."""

    tick: int
    payloads: TickPayloads
    numbers: Numbers
    present: tuple[bool, ...]
    """True for a robot that takes part [n]."""


def record(scenario: Scenario) -> list[Moment]:
    """All ticks of a run in one loop; raises FesError."""
    metrics, moments = MetricsCollector(scenario), []
    for tick in inprocess.ticks(scenario):
        metrics.add(tick.state, tick.twists, tick.telemetry)
        present = tuple(tick.state.present.tolist())
        moments.append(Moment(tick.state.tick, inprocess.payloads(tick), _numbers(metrics), present))
    return moments


def robots(
    scenario: Scenario,
    moments: Sequence[Moment],
    ids: Sequence[int],
    make: MakeCrew = lambda crew: crew,
    pause: Pause | None = None,
    renews: bool = False,
) -> Difference | None:
    """The first difference of robots `ids` that one crew executes again; None if all digits are the same.

    `make` may replace the laws of the crew. `pause` replaces the state of the crew in the middle, where another crew
    continues. With `renews` a robot that rejoins is a new crew, instead of one that forgets. Raises FesError.
    """
    group = _Group(scenario, ids, make)
    before: list[bytes] = [b""] * scenario.robots.number
    for moment in moments:
        if pause is not None and moment.tick == len(moments) // 2:
            group.restore(pause(group.state))
        beacons, commands = group.step(moment, before, renews)
        for robot in beacons:
            recorded = moment.payloads.beacons[robot], moment.payloads.commands[robot]
            for message, logged, computed in zip(
                ("Beacon", "Command"), recorded, (beacons[robot], commands[robot]), strict=True
            ):
                if logged != computed:
                    return difference.of_payloads(moment.tick, message, robot, logged, computed)
        before = moment.payloads.beacons
    return None


def world(
    scenario: Scenario,
    moments: Sequence[Moment],
    make: MakeWorld = lambda world, metrics: (world, metrics),
    pause: Pause | None = None,
) -> Difference | None:
    """The first difference of the world, executed again from the recorded commands; None if there is none.

    `make` may replace the world's parts. `pause` replaces the pair of state and metrics in the middle, where another
    world continues. Raises FesError.
    """
    simulation, metrics = make(truth.create(scenario), MetricsCollector(scenario))
    state, batch = truth.start(simulation), CommandBatch(simulation.ids)
    for moment in moments:
        if pause is not None and moment.tick == len(moments) // 2:
            state, metrics = pause((state, metrics))
            simulation, _ = make(truth.create(scenario), MetricsCollector(scenario))
        sensed = world_marshalling.observations(truth.observe(state), state.present, state.since)
        mismatch = difference.between(moment.tick, moment.payloads, moment.payloads._replace(observations=sensed))
        if mismatch is not None:
            return mismatch
        commands = [messages.decode_command(data) if data else None for data in moment.payloads.commands]
        twists, telemetry = batch.read(commands)
        metrics.add(state, twists, telemetry)
        numbers = _numbers(metrics)
        if numbers != moment.numbers:
            return Difference(moment.tick, "metrics", None, *_first(moment.numbers, numbers))
        state = truth.step(simulation, state, twists)
    return None


class _Group:
    """Robots that one crew hosts, fed with recorded messages."""

    def __init__(self, scenario: Scenario, ids: Sequence[int], make: MakeCrew) -> None:
        self._scenario, self._ids, self._make = scenario, ids, make
        self.restore(None)
        self.state: CrewState = crew.start(self._crew)

    def restore(self, state: CrewState | None) -> None:
        """Make another crew, which continues from a state."""
        numbers = np.array(self._ids, dtype=np.int64)
        self._crew = self._make(crew.create(agent_config(self._scenario), numbers))
        self._assembler, self._receiver = MessageAssembler(numbers), Receiver()
        if state is not None:
            self.state = state

    def step(self, moment: Moment, before: list[bytes], renews: bool) -> tuple[dict[int, bytes], dict[int, bytes]]:
        """The Beacons and Commands of a tick of the robots that take part, by id."""
        sensed = {
            robot: messages.decode_observation(moment.payloads.observations[robot])
            for robot in self._ids
            if moment.present[robot]
        }
        restarted = np.array(
            [robot in sensed and sensed[robot].since == moment.tick > 0 for robot in self._ids], dtype=np.bool_
        )
        if restarted.any() and renews:
            self.restore(None)
            self.state = crew.start(self._crew)
        elif restarted.any():
            self.state = crew.forget(self._crew, self.state, restarted)
        observations = self._assembler.observations(
            [sensed.get(robot) or _absent(moment.tick, robot) for robot in self._ids]
        )
        peers = [peer for peer in np.unique(observations.in_range.peers).tolist() if before[peer]]
        beacons = self._assembler.beacons(moment.tick - 1, [messages.decode_beacon(before[peer]) for peer in peers])
        received = self._receiver.receive(observations, beacons, self.state.contacts.edges)
        self.state, sent, twists, telemetry = crew.step(self._crew, self.state, observations.sensed, received)
        encoded = [
            payloads for payloads in agent_marshalling.encode_tick(sent, twists, telemetry) if payloads[0] in sensed
        ]
        return {robot: beacon for robot, beacon, _ in encoded}, {robot: command for robot, _, command in encoded}


def _absent(tick: int, robot: int) -> Observation:
    """Observation for a robot that takes no part; its state is discarded when it rejoins."""
    nothing = np.zeros(0, dtype=np.int64)
    return Observation(tick, robot, (0.0, 0.0, 0.0), nothing, nothing.astype(np.uint8), over=False, since=0)


def _numbers(metrics: MetricsCollector) -> Numbers:
    return {name: dict(metric.result()) for name, metric in metrics.extensions.items()}


def _first(before: Numbers, now: Numbers) -> tuple[str, Any, Any]:
    """The first result that differs: its name, and both values."""
    for name, values in now.items():
        for key in [*values, *before.get(name, {})]:
            first, second = before.get(name, {}).get(key), values.get(key)
            if first != second:
                return f"{name}.{key}", first, second
    return "names", list(before), list(now)
