"""The same world and the same crew in one loop, without Zenoh: same digits, no processes."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents import crew
from fes.arrays import Floats
from fes.errors import Stopped
from fes.report import Report
from fes.sensing import Beacons, silence
from world import reporting, simulation, summary
from world.metrics import Tally
from world.optimum import optimal_separation
from world.scenario import Scenario, agent_config
from world.simulation import State

Watch = Callable[[Report], None]
Keep = Callable[[dict[str, Any]], None]


@dataclass(frozen=True, eq=False)
class Tick:
    """What was true at one tick, and what the robots then said and did."""

    state: State
    said: Beacons
    twists: Floats
    """[n, 2] [m/s, rad/s]"""


def ticks(scenario: Scenario) -> Iterator[Tick]:
    """All ticks of a scenario, in order."""
    world = simulation.create(scenario)
    state = simulation.start(world)
    robots = crew.assemble(agent_config(scenario), world.ids)
    minds, said = crew.start(robots), silence()
    for _ in range(scenario.ticks):
        minds, said, twists = crew.step(robots, minds, simulation.observe(state), said)
        yield Tick(state, said, twists)
        state = simulation.step(world, state, twists)


def open_tally(scenario: Scenario) -> Tally:
    """The tally of a run that has not begun."""
    return Tally(scenario.run.dt, optimal_separation(scenario.objective, scenario.channel))


def account(tally: Tally, tick: Tick) -> None:
    """Add a tick to a tally."""
    state, said = tick.state, tick.said
    tally.add(state.poses, tick.twists, state.proximity, state.sent > 0, said.links, said.estimates)


def conclude(scenario: Scenario, name: str, tally: Tally, tick: Tick, wall: float) -> dict[str, Any]:
    """The summary of a run whose last tick is `tick`, after `wall` [s] of wall-clock time."""
    said = tick.said
    return summary.summarize(scenario, name, "inprocess", tally, tick.state, said.links, said.estimates, wall)


def run(
    scenario: Scenario, name: str, rtf: float | None = None, watch: Watch | None = None, keep: Keep | None = None
) -> dict[str, Any]:
    """Run a scenario to its end, and return its summary.

    `watch` is called with a Report every tenth of a second of wall-clock time, and `keep` with the summary of what
    was reached if a signal stops the run. With `rtf` the run is paced to that many simulated seconds a second.
    """
    tally = open_tally(scenario)
    alive = np.ones(scenario.robots.number, dtype=np.uint8)
    begun = told_at = time.perf_counter()
    told = 0
    tick = None
    try:
        for tick in ticks(scenario):
            account(tally, tick)
            state, links, estimates = tick.state, tick.said.links, tick.said.estimates
            now = time.perf_counter()
            if watch is not None and (now - told_at >= reporting.PERIOD or tally.ticks == scenario.ticks):
                rate = (tally.ticks - told) / (now - told_at)
                watch(reporting.build(scenario, name, state, tally, links, estimates, alive, now - begun, rate))
                told_at, told = now, tally.ticks
            if rtf is not None:
                time.sleep(max(0.0, begun + tally.ticks * scenario.run.dt / rtf - time.perf_counter()))
    except Stopped:
        if keep is not None and tick is not None and tally.ticks:
            keep(conclude(scenario, name, tally, tick, time.perf_counter() - begun))
        raise
    assert tick is not None  # a scenario has at least one tick
    return conclude(scenario, name, tally, tick, time.perf_counter() - begun)
