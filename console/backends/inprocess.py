"""World and robots in one loop, without Zenoh or processes, and with the same digits."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.control import crew
from agents.core.compiled_crew import Sent
from agents.runtime import marshalling as agent_marshalling
from agents.runtime.crew_run import CrewRun
from fes import process
from fes.arrays import masks
from fes.arrays.types import Floats
from fes.errors import FesError, ScenarioError
from fes.model.sensing import Beacons, Telemetry, no_beacons, telemetry_of
from fes.protocol.report import Report
from fes.recording.layout import PackedPayloads, TickPayloads
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
    """The state of the world at one tick, and the beacons, twists and telemetry of the robots."""

    state: State
    beacons: Beacons
    twists: Floats
    """[n, 2] [m/s, rad/s]"""
    telemetry: Telemetry
    """Telemetry of the robots that are present."""
    crew: CrewRun | None = None
    """The crew, which is at this tick until the next one is computed; None if several runs share one."""


def check(scenario: Scenario) -> None:
    """Raise ScenarioError if a scenario cannot be run in one loop."""
    if scenario.run.clock == "live":
        raise ScenarioError("run.clock", "'live' needs processes: robots in one loop cannot be late")


def ticks(scenario: Scenario) -> Iterator[Tick]:
    """All ticks of a scenario, in order."""
    world = truth.create(scenario)
    state = truth.start(world)
    robots, beacons = CrewRun(crew.create(agent_config(scenario), world.ids)), no_beacons()
    present = state.present
    for _ in range(scenario.ticks):
        if state.present is not present:
            robots.forget(state.present & ~present)
            present = state.present
        beacons, twists, telemetry = robots.step(truth.observe(state), beacons)
        current = tick(state, beacons, twists, telemetry, robots)
        yield current
        state = truth.step(world, state, current.twists)


def tick(state: State, beacons: Beacons, twists: Floats, telemetry: Telemetry, robots: CrewRun | None = None) -> Tick:
    """A tick, from the output of a crew that includes absent robots."""
    present = state.present
    if not masks.is_full(present):
        telemetry = telemetry_of(telemetry, present)
    return Tick(state, beacons, truth.held(state, twists), telemetry, robots)


def payloads(tick: Tick) -> TickPayloads:
    """The messages that would cross the bus at a tick, to the byte."""
    present, decodable = tick.state.present, tick.state.decodable
    encoded = list(agent_marshalling.encode_tick(tick.beacons, tick.twists, tick.telemetry))
    sensed = world_marshalling.observations(truth.observe(tick.state), present, tick.state.since)
    beacons = [data if shown else b"" for (_, data, _), shown in zip(encoded, decodable.tolist(), strict=True)]
    commands = [data if shown else b"" for (_, _, data), shown in zip(encoded, present.tolist(), strict=True)]
    return TickPayloads(sensed, beacons, commands)


def packed(tick: Tick) -> TickPayloads | PackedPayloads:
    """The same messages; those of the last tick are packed by the compiled core, where it moves the crew."""
    state, written = tick.state, None
    if tick.crew is not None:
        sent = Sent(tick.beacons, tick.twists, tick.telemetry)
        written = tick.crew.payloads(sent, state.since, state.present, state.decodable)
    return payloads(tick) if written is None else PackedPayloads(*written)


def run(
    scenario: Scenario,
    name: str,
    rtf: float | None = None,
    watch: Watch | None = None,
    keep: Keep | None = None,
    recorder: Recorder | None = None,
    collect: Callable[[Tick], None] | None = None,
) -> dict[str, Any]:
    """Run a scenario to its end, and return its summary.

    `watch` is called with a Report ten times per second of wall clock. `keep` is called with the summary, at the end
    or when a signal stops the run. With `rtf` the run is paced to that many simulated seconds per second. `recorder`
    and `collect` get every tick.
    """
    metrics = MetricsCollector(scenario)
    alive = np.ones(scenario.robots.number, dtype=np.uint8)
    begun = report_time = time.perf_counter()
    reported = 0

    def summarize() -> dict[str, Any]:
        return summary.summarize(metrics, name, "inprocess", time.perf_counter() - begun)

    try:
        for done, tick in enumerate(ticks(scenario), 1):
            with process.uninterrupted():  # metrics and log have the same ticks
                metrics.add(tick.state, tick.twists, tick.telemetry)
                now = time.perf_counter()
                if recorder is not None:
                    recorder.add(metrics, tick.twists, packed(tick), alive, now - begun)
            if collect is not None:
                collect(tick)
            if watch is not None and (now - report_time >= report_builder.PERIOD or done == scenario.ticks):
                watch(
                    report_builder.build(metrics, name, alive, now - begun, (done - reported) / (now - report_time))
                )
                report_time, reported = now, done
            if rtf is not None:
                time.sleep(max(0.0, begun + done * scenario.run.dt / rtf - time.perf_counter()))
    except FesError:
        if keep is not None and metrics.link_errors.ticks:
            keep(summarize())
        raise
    result = summarize()
    if keep is not None:
        keep(result)
    return result
