"""The same world and the same crew in one loop, without Zenoh: same digits, no processes."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.control import crew
from agents.runtime import marshalling as agent_marshalling
from fes.arrays.types import Floats
from fes.errors import FesError, ScenarioError
from fes.model.sensing import Beacons, Telemetry, no_beacons, of_those
from fes.protocol.report import Report
from fes.recording.layout import TickPayloads
from world.config.scenario import Scenario, agent_config
from world.execution import marshalling as world_marshalling
from world.execution.recorder import Recorder
from world.metrics import report_builder, summary
from world.metrics.collector import MetricsCollector
from world.simulation import truth
from world.simulation.truth import State

Watch = Callable[[Report], None]
Keep = Callable[[dict[str, Any]], None]


@dataclass(frozen=True, eq=False)
class Tick:
    """What was true at one tick, and what the robots then said and did."""

    state: State
    said: Beacons
    twists: Floats
    """[n, 2] [m/s, rad/s]"""
    telemetry: Telemetry
    """Of the robots that are present."""


def check(scenario: Scenario) -> None:
    """Raise ScenarioError if a scenario cannot be run in one loop."""
    if scenario.run.clock == "live":
        raise ScenarioError("run.clock", "'live' needs processes: what is in one loop cannot be late")


def ticks(scenario: Scenario) -> Iterator[Tick]:
    """All ticks of a scenario, in order."""
    world = truth.create(scenario)
    state = truth.start(world)
    robots = crew.create(agent_config(scenario), world.ids)
    minds, said = crew.start(robots), no_beacons()
    present = state.present
    for _ in range(scenario.ticks):
        if state.present is not present:
            minds = crew.forget(robots, minds, state.present & ~present)
            present = state.present
        minds, said, twists = crew.step(robots, minds, truth.observe(state), said)
        now = tick(state, said, twists, crew.telemetry(robots, minds))
        yield now
        state = truth.step(world, state, now.twists)


def tick(state: State, said: Beacons, twists: Floats, told: Telemetry) -> Tick:
    """A tick, of what a crew said and did, absent robots included."""
    present = state.present
    shown = told if present.all() else of_those(told, present)
    return Tick(state, said, truth.held(state, twists), shown)


def said(tick: Tick) -> TickPayloads:
    """What would have crossed the bus at a tick, to the byte."""
    present, legible = tick.state.present, tick.state.decodable
    spoken = list(agent_marshalling.encode_tick(tick.said, tick.twists, tick.telemetry))
    sensed = world_marshalling.observations(truth.observe(tick.state), present, tick.state.since)
    beacons = [beacon if whole else b"" for (_, beacon, _), whole in zip(spoken, legible.tolist(), strict=True)]
    commands = [command if here else b"" for (_, _, command), here in zip(spoken, present.tolist(), strict=True)]
    return TickPayloads(sensed, beacons, commands)


def run(
    scenario: Scenario,
    name: str,
    rtf: float | None = None,
    watch: Watch | None = None,
    keep: Keep | None = None,
    recorder: Recorder | None = None,
) -> dict[str, Any]:
    """Run a scenario to its end, and return its summary.

    `watch` is called with a Report every tenth of a second of wall-clock time, and `keep` with the summary of what
    was reached, at the end or when a signal stops the run. With `rtf` the run is paced to that many simulated seconds
    a second. `recorder` gets every tick.
    """
    metrics = MetricsCollector(scenario)
    alive = np.ones(scenario.robots.number, dtype=np.uint8)
    begun = told_at = time.perf_counter()
    told = 0

    def reached() -> dict[str, Any]:
        return summary.summarize(metrics, name, "inprocess", time.perf_counter() - begun)

    try:
        for done, tick in enumerate(ticks(scenario), 1):
            metrics.add(tick.state, tick.twists, tick.telemetry)
            now = time.perf_counter()
            if recorder is not None:
                recorder.add(metrics, tick.twists, said(tick), alive, now - begun)
            if watch is not None and (now - told_at >= report_builder.PERIOD or done == scenario.ticks):
                watch(report_builder.build(metrics, name, alive, now - begun, (done - told) / (now - told_at)))
                told_at, told = now, done
            if rtf is not None:
                time.sleep(max(0.0, begun + done * scenario.run.dt / rtf - time.perf_counter()))
    except FesError:
        if keep is not None and metrics.link_errors.ticks:
            keep(reached())
        raise
    result = reached()
    if keep is not None:
        keep(result)
    return result
