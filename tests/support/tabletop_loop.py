"""A crew that drives bodies on a table in one loop, without Zenoh: the world's channel at the true positions.

`python -m tests.support.tabletop_loop` prints the figures of three seeds over 60 s with bodies in MuJoCo.
"""

import dataclasses
import sys
import time
from collections.abc import Iterator
from typing import Any

from agents.control import crew
from agents.runtime.crew_run import CrewRun
from console.backends import inprocess
from console.backends.inprocess import Tick
from fes.arrays.types import Floats
from fes.model.sensing import no_beacons
from tests.support import loop
from world.config.hardware.tabletop import TabletopConfig
from world.config.scenario import Scenario, agent_config
from world.metrics import summary
from world.metrics.collector import MetricsCollector
from world.simulation import truth
from world.tabletop.bodies import team
from world.tabletop.bodies.interface import Bodies


class TableDynamics:
    """Bodies on a table as the dynamics of a world: the conversion that each robot's gate makes."""

    def __init__(self, scenario: Scenario, config: TabletopConfig) -> None:
        self._scenario, self._config = scenario, config

    def start(self, poses: Floats) -> Bodies:
        return team.create(self._scenario, self._config)

    def step(self, state: Bodies, twists: Floats, dt: float) -> Bodies:
        for robot, (linear, angular) in enumerate(twists.tolist()):
            state.command(robot, linear / self._config.scale, angular)
        state.step(dt)
        return state

    def poses(self, state: Bodies) -> Floats:
        return team.at_full_size(state.poses(), self._config.scale)


def ticks(scenario: Scenario) -> Iterator[Tick]:
    """All ticks of a crew whose bodies are those of the table [tabletop]."""
    config = scenario.tabletop
    assert config is not None
    world = dataclasses.replace(truth.create(scenario), dynamics=TableDynamics(scenario, config), core=None)
    state = truth.start(world)
    robots, beacons = CrewRun(crew.create(agent_config(scenario), world.ids)), no_beacons()
    for _ in range(scenario.ticks):
        beacons, twists, telemetry = robots.step(truth.observe(state), beacons)
        yield inprocess.tick(state, beacons, twists, telemetry)
        state = truth.step(world, state, twists)


def load(body: str, seed: int, duration: float) -> Scenario:
    """The scenario `tabletop` with these bodies."""
    return loop.load("tabletop.toml", tabletop__body=body, run__seed=seed, run__duration=duration)


def run(scenario: Scenario) -> dict[str, Any]:
    """The summary of a run, with its speed."""
    metrics, begun = MetricsCollector(scenario), time.perf_counter()
    for tick in ticks(scenario):
        metrics.add(tick.state, tick.twists, tick.telemetry)
    return summary.summarize(metrics, "tabletop", "inprocess", time.perf_counter() - begun)


def main() -> int:
    """Print the figures of three seeds."""
    for body in ("kinematic", "mujoco"):
        for seed in (1, 2, 3):
            results = run(load(body, seed, 60.0))
            times = ", ".join(f"{name} {time} s" for name, time in results["time_to"].items())
            print(
                f"{body}, seed {seed}: {times}; rms at the end {results['separation_error_rms']:.2f} m; "
                f"nearest two {results['smallest_separation']:.1f} m; {results['real_time_factor']:.1f} x real time",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
