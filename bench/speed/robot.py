"""Computation per tick of one robot's process, and of the world's, measured warm in one process.

A tick passes through all its stages: observations, beacons and commands are encoded and decoded as on the wire. Each
robot is a crew of its own.
"""

import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from agents.control import crew
from agents.runtime import marshalling
from agents.runtime.marshalling import MessageAssembler
from agents.runtime.reception import Receiver
from fes.model.sensing import Telemetry
from fes.protocol import messages
from fes.protocol.messages import Observation
from world.config.scenario import agent_config, load
from world.metrics.collector import MetricsCollector
from world.simulation import truth


@dataclass
class Costs:
    """Times per tick [s]."""

    decoding: list[float] = field(default_factory=list)
    step: list[float] = field(default_factory=list)
    encoding: list[float] = field(default_factory=list)
    world: list[float] = field(default_factory=list)

    @property
    def robot(self) -> float:
        """Median total of a robot's process [s]."""
        return float(np.median(self.decoding) + np.median(self.step) + np.median(self.encoding))

    @property
    def world_tick(self) -> float:
        """Median total of the world's process [s]."""
        return float(np.median(self.world))


def measure(path: Path, ticks: int = 300, skip: int = 400) -> Costs:
    """Costs of a scenario's robots, over `ticks` ticks after the first `skip`."""
    scenario = load(path)
    world = truth.create(scenario)
    state = truth.start(world)
    config, ids = agent_config(scenario), world.ids.tolist()
    crews = [crew.create(config, np.array([robot])) for robot in ids]
    states = [crew.start(robot_crew) for robot_crew in crews]
    assemblers = [MessageAssembler(np.array([robot])) for robot in ids]
    receivers = [Receiver() for _ in ids]
    assembler = MessageAssembler(world.ids)
    metrics = MetricsCollector(scenario)
    costs, clock = Costs(), time.perf_counter
    previous_beacons: dict[int, bytes] = {}
    for tick in range(skip + ticks):
        if tick == skip:
            costs = Costs()
        begun = clock()
        observations = truth.observe(state)
        rows = zip(ids, observations.poses.tolist(), observations.in_range.spans, strict=True)
        sensed = [
            messages.encode_observation(
                Observation(
                    tick,
                    robot,
                    tuple(pose),
                    observations.in_range.peers[span],
                    observations.reception[span],
                    over=False,
                    since=0,
                )
            )
            for robot, pose, span in rows
        ]
        world_time = clock() - begun
        beacons, commands = {}, []
        for robot in ids:
            begun = clock()
            observation = messages.decode_observation(sensed[robot])
            payloads = [previous_beacons[peer] for peer in observation.in_range.tolist() if peer in previous_beacons]
            inputs = assemblers[robot].observations([observation])
            received_beacons = assemblers[robot].beacons(
                tick - 1, [messages.decode_beacon(beacon) for beacon in payloads]
            )
            decoded = clock()
            known = receivers[robot].receive(inputs, received_beacons, states[robot].contacts.edges)
            states[robot], sent, twists, telemetry = crew.step(crews[robot], states[robot], inputs.sensed, known)
            stepped = clock()
            [(_, beacon, command)] = marshalling.encode_tick(sent, twists, telemetry)
            costs.encoding.append(clock() - stepped)
            costs.step.append(stepped - decoded)
            costs.decoding.append(decoded - begun)
            beacons[robot] = beacon
            commands.append(command)
        previous_beacons = beacons
        begun = clock()
        received = [messages.decode_command(payload) for payload in commands]
        links = assembler._links.edges(world.ids, [command.links for command in received])
        estimates = np.concatenate([command.estimates for command in received])
        twists_applied = np.array([command.twist for command in received])
        before, state = state, truth.step(world, state, twists_applied)
        metrics.add(before, twists_applied, Telemetry(links, estimates, np.zeros((2, 0)), np.zeros((len(ids), 0))))
        costs.world.append(world_time + clock() - begun)
    return costs
