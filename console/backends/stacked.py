"""Several runs as one array program: one crew steps the robots of all runs, and each run has its own world.

Robots of different runs are never in range of each other, so they share only the arrays. A robot's digits do not
depend on the other robots of its process (`fes.arrays.edges`). Its random numbers are those of its seed and its id
within its run. So each run has the digest that it has alone. Stacking saves numpy's cost per call, which dominates
for ten robots.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.control import crew
from agents.control.state import Crew
from agents.runtime.crew_run import CrewRun
from console.backends import inprocess
from console.backends.inprocess import Tick
from console.terminal import counting
from console.terminal.counting import Watch
from fes.arithmetic import draws
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.extension.context import SeededDraws
from fes.model.config import AgentConfig
from fes.model.sensing import Observations, Telemetry, no_beacons
from world.config.scenario import Scenario, agent_config
from world.metrics import summary
from world.metrics.collector import MetricsCollector
from world.simulation import truth
from world.simulation.truth import State


def alike(scenario: Scenario) -> tuple[AgentConfig, int]:
    """The settings that stacked runs must share: those of the robots except the seed, and the number of ticks."""
    return agent_config(scenario).model_copy(update={"seed": 0}), scenario.ticks


def run(scenarios: Sequence[Scenario], name: str, watch: Watch = counting.ignore) -> list[dict[str, Any]]:
    """The summaries of runs that are alike; each equals that of `console.backends.inprocess.run`, wall clock aside.

    `watch` is called after each tick with the number of finished ticks of all runs.
    """
    metrics = [MetricsCollector(scenario) for scenario in scenarios]
    begun = time.perf_counter()
    for number, together in enumerate(ticks(scenarios), 1):
        for collector, tick in zip(metrics, together, strict=True):
            collector.add(tick.state, tick.twists, tick.telemetry)
        watch(number * len(scenarios))
    wall = time.perf_counter() - begun
    return [summary.summarize(collector, name, "inprocess", wall) for collector in metrics]


def ticks(scenarios: Sequence[Scenario], data_sheets: Sequence[Scenario] | None = None) -> Iterator[list[Tick]]:
    """All ticks in order, each as one Tick per run, without the beacons: the robots hear them as one crew.

    `data_sheets`, if given, has the settings that each run's robots know. So a study can hide what their world does.
    """
    worlds = [truth.create(scenario) for scenario in scenarios]
    states = [truth.start(world) for world in worlds]
    places = _Places.of([world.ids for world in worlds])
    robots = CrewRun(_assemble(data_sheets or scenarios, places))
    joined, split = _Joined(places), _Split(places)
    beacons = unshared = no_beacons()
    present = [state.present for state in states]
    for _ in range(scenarios[0].ticks):
        now = [state.present for state in states]
        if any(new is not old for new, old in zip(now, present, strict=True)):
            rejoined = [new & ~old for new, old in zip(now, present, strict=True)]
            robots.forget(np.concatenate(rejoined))
            present = now
        beacons, twists, telemetry = robots.step(joined.observations(states), beacons)
        by_run = zip(states, places.rows(twists), split.telemetry(telemetry), strict=True)
        finished = [inprocess.tick(state, unshared, held, learnt) for state, held, learnt in by_run]
        yield finished
        states = [truth.step(world, tick.state, tick.twists) for world, tick in zip(worlds, finished, strict=True)]


@dataclass(frozen=True, eq=False)
class _Places:
    """The places of the runs' robots in the crew: run after run, each in the order of its own ids from 0 on."""

    own: list[Ints]
    """The ids of the robots within each run."""
    first: Ints
    """Id in the crew of each run's robot 0, then the number of all robots."""

    @staticmethod
    def of(own: list[Ints]) -> "_Places":
        return _Places(own, np.cumsum([0, *map(len, own)]))

    def rows(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """The rows of `values` of each run."""
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

    def streams(self, stream: str, ids: Ints) -> tuple[Ints, Ints]:
        """The key of the stream for each robot [n, 2], and the id of robot 0 of its run in the crew [n]."""
        runs = np.searchsorted(self.places.first, ids, "right") - 1
        keys = np.stack([draws.key(run.seed, stream) for run in self.runs])
        return keys[runs], self.places.first[runs]

    def own_ids(self, ids: Ints) -> Ints:
        """The ids within their runs of robots with these ids in the crew."""
        first: Ints = self.places.first[np.searchsorted(self.places.first, ids, "right") - 1]
        return ids - first


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
    """The observations of all runs as those of one crew; the same edges object while no run changes its own."""

    def __init__(self, places: _Places) -> None:
        self._places = places
        self._ids = np.arange(places.first[-1])
        self._parts: list[Edges] = []
        self._edges: Edges | None = None

    def observations(self, states: list[State]) -> Observations:
        """The observations of all runs, in the order of the crew."""
        sensed = [truth.observe(state) for state in states]
        return Observations(
            sensed[0].tick,
            np.concatenate([observations.poses for observations in sensed]),
            self._in_range([observations.in_range for observations in sensed]),
            np.concatenate([observations.reception for observations in sensed]),
            _ticks(sensed),
        )

    def _in_range(self, parts: list[Edges]) -> Edges:
        if self._edges is None or any(new is not old for new, old in zip(parts, self._parts, strict=True)):
            first = self._places.first[:-1].tolist()
            rows = np.concatenate([part.rows + offset for part, offset in zip(parts, first, strict=True)])
            peers = np.concatenate([part.peers + offset for part, offset in zip(parts, first, strict=True)])
            self._parts, self._edges = parts, Edges(self._ids, rows, peers)
        return self._edges


def _ticks(sensed: list[Observations]) -> Ints | None:
    """Tick at which each pose was measured; None if all were at this tick."""
    if all(observations.fixed is None for observations in sensed):
        return None
    ticks = [np.full(len(run.poses), run.tick) if run.fixed is None else run.fixed for run in sensed]
    return np.concatenate(ticks)


class _Split:
    """The telemetry of each run, from that of the crew.

    A run's links are the same object while its pairs are the same.
    """

    def __init__(self, places: _Places) -> None:
        self._places = places
        self._links: Edges | None = None
        self._parts: list[Edges] = []
        self._cuts: list[slice] = []

    def telemetry(self, telemetry: Telemetry) -> list[Telemetry]:
        """The telemetry of each run."""
        self._update(telemetry.links)
        parts = zip(self._parts, self._cuts, self._places.rows(telemetry.details), strict=True)
        return [
            Telemetry(links, telemetry.estimates[cut], telemetry.learnt[:, cut], details)
            for links, cut, details in parts
        ]

    def _update(self, links: Edges) -> None:
        if links is self._links:
            return
        parts = _parts(links, self._places)
        if self._parts:
            parts = [old if _same(old, new) else new for old, new in zip(self._parts, parts, strict=True)]
        ends = np.cumsum([0, *map(len, parts)]).tolist()
        self._links, self._parts, self._cuts = links, parts, list(map(slice, ends[:-1], ends[1:]))


def _same(a: Edges, b: Edges) -> bool:
    return a.rows.tobytes() == b.rows.tobytes() and a.peers.tobytes() == b.peers.tobytes()
