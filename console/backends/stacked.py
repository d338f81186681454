"""Several runs as one array program: one crew steps the robots of all of them, each run has a world of its own.

Robots of different runs are never in range of each other, so they share nothing but the arrays. A robot's digits do
not depend on who else shares its process (`fes.arrays.edges`), and its seed and its id within its run are looked up
where numbers are drawn. So every run has the digest that it has alone. What it saves is numpy's cost a call, which
for ten robots is most of the time.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.control import crew
from agents.control.state import Crew
from agents.laws.draws import SeededDraws
from console.backends import inprocess
from console.backends.inprocess import Tick
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.model.config import AgentConfig
from fes.model.sensing import Beacons, Observations, Telemetry, no_beacons
from world.config.scenario import Scenario, agent_config
from world.metrics import summary
from world.metrics.collector import MetricsCollector
from world.simulation import truth
from world.simulation.truth import State


def alike(scenario: Scenario) -> tuple[AgentConfig, int]:
    """What runs must have in common to be stacked: all that their robots are told but the seed, and the ticks."""
    return agent_config(scenario).model_copy(update={"seed": 0}), scenario.ticks


def run(scenarios: Sequence[Scenario], name: str, watch: Callable[[int], None] | None = None) -> list[dict[str, Any]]:
    """The summaries of runs that are alike, each equal to that of `console.backends.inprocess.run` but for the
    wall-clock.

    `watch`, if given, is called after each tick with the ticks that are done, of all runs together.
    """
    metrics = [MetricsCollector(scenario) for scenario in scenarios]
    begun = time.perf_counter()
    for number, together in enumerate(ticks(scenarios), 1):
        for one, tick in zip(metrics, together, strict=True):
            one.add(tick.state, tick.twists, tick.telemetry)
        if watch is not None:
            watch(number * len(scenarios))
    wall = time.perf_counter() - begun
    return [summary.summarize(one, name, "inprocess", wall) for one in metrics]


def ticks(scenarios: Sequence[Scenario]) -> Iterator[list[Tick]]:
    """All ticks in order, each as one Tick a run."""
    worlds = [truth.create(scenario) for scenario in scenarios]
    states = [truth.start(world) for world in worlds]
    places = _Places.of([world.ids for world in worlds])
    robots = _assemble(scenarios, places)
    sensing, saying = _Joined(places), _Split(places)
    minds, said, there = crew.start(robots), no_beacons(), [state.present for state in states]
    for _ in range(scenarios[0].ticks):
        now = [state.present for state in states]
        if any(new is not old for new, old in zip(now, there, strict=True)):
            back = [new & ~old for new, old in zip(now, there, strict=True)]
            minds, there = crew.forget(robots, minds, np.concatenate(back)), now
        minds, said, twists = crew.step(robots, minds, sensing.observations(states), said)
        told = saying.beacons(said), places.rows(twists), saying.telemetry(crew.telemetry(robots, minds))
        found = [inprocess.tick(*of_run) for of_run in zip(states, *told, strict=True)]
        yield found
        states = [truth.step(world, tick.state, tick.twists) for world, tick in zip(worlds, found, strict=True)]


@dataclass(frozen=True, eq=False)
class _Places:
    """Where each run's robots stand in the crew: run after run, each in the order of its own ids from 0 on."""

    own: list[Ints]
    """The robots of each run, by their ids in it."""
    first: Ints
    """Id in the crew of each run's robot 0, and at last the number of all robots."""

    @staticmethod
    def of(own: list[Ints]) -> "_Places":
        return _Places(own, np.cumsum([0, *map(len, own)]))

    def rows(self, values: Floats) -> list[Floats]:
        """The rows of each run."""
        return [values[a:b] for a, b in zip(self.first[:-1].tolist(), self.first[1:].tolist(), strict=True)]


@dataclass(frozen=True, eq=False)
class _StackedDraws:
    """The random numbers of several runs in one crew: each pair gets those that it has in its own run."""

    runs: list[SeededDraws]
    places: _Places

    def __call__(self, stream: str, robots: Ints, peers: Ints) -> Floats:
        """A uniform number in [0, 1) for each pair of ids in the crew (robot, peer) [m]."""
        numbers = np.empty(len(robots))
        indices = np.searchsorted(self.places.first, robots, "right") - 1
        for index in np.unique(indices).tolist():
            pairs, own, first = indices == index, self.places.own[index], self.places.first[index]
            numbers[pairs] = self.runs[index](stream, own[robots[pairs] - first], own[peers[pairs] - first])
        return numbers


def _assemble(scenarios: Sequence[Scenario], places: _Places) -> Crew:
    """The crew of all runs."""
    config = agent_config(scenarios[0])
    faults = [
        fault.model_copy(update={"robot": fault.robot + first})
        for first in places.first[:-1].tolist()
        for fault in config.faults
    ]
    seeds = [SeededDraws(agent_config(scenario).seed) for scenario in scenarios]
    stacked = config.model_copy(update={"faults": faults})
    return crew.create(stacked, np.arange(places.first[-1]), _StackedDraws(seeds, places))


def _parts(edges: Edges, places: _Places) -> list[Edges]:
    """The pairs of each run, by the ids that its robots have in it."""
    cuts = np.searchsorted(edges.rows, places.first).tolist()
    return [
        Edges(own, edges.rows[a:b] - first, edges.peers[a:b] - first)
        for own, first, a, b in zip(places.own, places.first[:-1].tolist(), cuts[:-1], cuts[1:], strict=True)
    ]


class _Joined:
    """What the robots of all runs sense; the same edges while nobody's changed, so that nobody recomputes."""

    def __init__(self, places: _Places) -> None:
        self._places = places
        self._ids = np.arange(places.first[-1])
        self._parts: list[Edges] = []
        self._edges: Edges | None = None

    def observations(self, states: list[State]) -> Observations:
        sensed = [truth.observe(state) for state in states]
        return Observations(
            sensed[0].tick,
            np.concatenate([one.poses for one in sensed]),
            self._in_range([one.in_range for one in sensed]),
            np.concatenate([one.reception for one in sensed]),
        )

    def _in_range(self, parts: list[Edges]) -> Edges:
        if self._edges is None or any(new is not old for new, old in zip(parts, self._parts, strict=True)):
            first = self._places.first[:-1].tolist()
            rows = np.concatenate([part.rows + offset for part, offset in zip(parts, first, strict=True)])
            peers = np.concatenate([part.peers + offset for part, offset in zip(parts, first, strict=True)])
            self._parts, self._edges = parts, Edges(self._ids, rows, peers)
        return self._edges


class _Split:
    """What the robots of each run say; a run's links are the same object while they are the same pairs."""

    def __init__(self, places: _Places) -> None:
        self._places = places
        self._links: Edges | None = None
        self._parts: list[Edges] = []
        self._cuts: list[slice] = []

    def beacons(self, said: Beacons) -> list[Beacons]:
        self._take_in(said.links)
        by_robot = zip(self._places.own, *map(self._places.rows, (said.poses, said.statistics)), strict=True)
        return [
            Beacons(said.tick, own, poses, links, said.estimates[cut], said.selected[cut], statistics)
            for (own, poses, statistics), links, cut in zip(by_robot, self._parts, self._cuts, strict=True)
        ]

    def telemetry(self, said: Telemetry) -> list[Telemetry]:
        self._take_in(said.links)  # those of the beacons, unless a transmitter is late
        rows = zip(self._parts, self._cuts, strict=True)
        return [Telemetry(links, said.estimates[cut], said.learnt[:, cut]) for links, cut in rows]

    def _take_in(self, links: Edges) -> None:
        if links is self._links:
            return
        parts = _parts(links, self._places)
        if self._parts:
            parts = [old if _same(old, new) else new for old, new in zip(self._parts, parts, strict=True)]
        ends = np.cumsum([0, *map(len, parts)]).tolist()
        self._links, self._parts, self._cuts = links, parts, list(map(slice, ends[:-1], ends[1:]))


def _same(a: Edges, b: Edges) -> bool:
    return a.rows.tobytes() == b.rows.tobytes() and a.peers.tobytes() == b.peers.tobytes()
