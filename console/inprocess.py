"""The same world and the same crew in one loop, without Zenoh: same digits, no processes."""

import time
from collections.abc import Callable
from typing import Any

from agents import crew
from fes.report import Report
from fes.sensing import silence
from world import reporting, simulation, summary
from world.metrics import Tally
from world.optimum import optimal_separation
from world.scenario import Scenario, agent_config

Watch = Callable[[Report], None]


def run(scenario: Scenario, name: str, rtf: float | None = None, watch: Watch | None = None) -> dict[str, Any]:
    """Run a scenario to its end, and return its summary.

    `watch` is called with a Report every tenth of a second of wall-clock time. With `rtf` the run is paced to
    that many simulated seconds a second.
    """
    world = simulation.create(scenario)
    state = simulation.start(world)
    robots = crew.assemble(agent_config(scenario), world.ids)
    minds, said = crew.start(robots), silence()
    tally = Tally(scenario.run.dt, optimal_separation(scenario.objective, scenario.channel))
    begun = told_at = time.perf_counter()
    told = 0
    for tick in range(scenario.ticks):
        minds, said, twists = crew.step(robots, minds, simulation.observe(state), said)
        now = state
        state = simulation.step(world, now, twists)
        tally.add(now.poses, twists, now.proximity, now.sent > 0, said.links, said.estimates)
        if watch is not None and (time.perf_counter() - told_at >= reporting.PERIOD or tick + 1 == scenario.ticks):
            clock = time.perf_counter()
            alive = (world.ids >= 0).view("uint8")
            rate = (tally.ticks - told) / (clock - told_at)
            watch(reporting.build(scenario, name, now, tally, said.links, said.estimates, alive, clock - begun, rate))
            told_at, told = clock, tally.ticks
        if rtf is not None:
            time.sleep(max(0.0, begun + tally.ticks * scenario.run.dt / rtf - time.perf_counter()))
    wall = time.perf_counter() - begun
    return summary.summarize(scenario, name, "inprocess", tally, now, said.links, said.estimates, wall)
