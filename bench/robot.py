"""What one robot's process computes in a tick, and what the world's does, measured warm in one process.

The whole way of a tick is walked: observations, beacons and commands are encoded and decoded as they would be
on the wire, and each robot is a crew of its own.
"""

import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from agents.control import crew
from agents.runtime import marshalling
from agents.runtime.marshalling import MessageAssembler
from fes.model.sensing import Telemetry
from fes.protocol import messages
from fes.protocol.messages import Observation
from world.config.scenario import agent_config, load
from world.metrics.collector import MetricsCollector
from world.simulation import truth


@dataclass
class Costs:
    """Median times a tick [s]."""

    read: list[float] = field(default_factory=list)
    step: list[float] = field(default_factory=list)
    say: list[float] = field(default_factory=list)
    world: list[float] = field(default_factory=list)

    @property
    def robot(self) -> float:
        """All that a robot's process computes."""
        return float(np.median(self.read) + np.median(self.step) + np.median(self.say))

    @property
    def world_tick(self) -> float:
        """All that the world's process computes."""
        return float(np.median(self.world))


def measure(path: Path, ticks: int = 300, skip: int = 400) -> Costs:
    """The costs of a scenario's robots, over `ticks` ticks after `skip`."""
    scenario = load(path)
    world = truth.create(scenario)
    state = truth.start(world)
    config, ids = agent_config(scenario), world.ids.tolist()
    crews = [crew.create(config, np.array([robot])) for robot in ids]
    minds = [crew.start(one) for one in crews]
    stacks = [MessageAssembler(np.array([robot])) for robot in ids]
    everybody = MessageAssembler(world.ids)
    metrics = MetricsCollector(scenario)
    costs, clock = Costs(), time.perf_counter
    spoken: dict[int, bytes] = {}
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
            near = [spoken[peer] for peer in observation.in_range.tolist() if peer in spoken]
            seen = stacks[robot].observations([observation])
            heard = stacks[robot].beacons(tick - 1, [messages.decode_beacon(payload) for payload in near])
            read = clock()
            minds[robot], said, twists = crew.step(crews[robot], minds[robot], seen, heard)
            stepped = clock()
            told = crew.telemetry(crews[robot], minds[robot])
            [(_, beacon, command)] = marshalling.encode_tick(said, twists, told)
            costs.say.append(clock() - stepped)
            costs.step.append(stepped - read)
            costs.read.append(read - begun)
            beacons[robot] = beacon
            commands.append(command)
        spoken = beacons
        begun = clock()
        received = [messages.decode_command(payload) for payload in commands]
        links = everybody._links.edges(world.ids, [command.links for command in received])
        estimates = np.concatenate([command.estimates for command in received])
        turned = np.array([command.twist for command in received])
        before, state = state, truth.step(world, state, turned)
        metrics.add(before, turned, Telemetry(links, estimates, np.zeros((2, 0))))
        costs.world.append(world_time + clock() - begun)
    return costs
