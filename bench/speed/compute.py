"""Computation of the laws: one robot's step, in-process rates, and cost per robot-tick from 10 to 10,000 robots."""

import time
from pathlib import Path

import numpy as np

from agents.control import crew
from agents.runtime.reception import Receiver
from bench.speed import robot
from fes.model.sensing import no_beacons
from world.config.scenario import Scenario, agent_config, load
from world.simulation import truth

CONFIGS = Path("configs")
SIZES = (10, 100, 1_000, 10_000)
SPACING = 78.0

FLAT = 1.5
"""Wanted ratio of the cost per robot-tick of a larger team to that of 100 robots, at most."""


def rate(scenario: Scenario, ticks: int, skip: int) -> float:
    """In-process ticks per second over `ticks` ticks, after `skip`."""
    world = truth.create(scenario)
    state = truth.start(world)
    robots = crew.create(agent_config(scenario), world.ids)
    states, beacons, receiver = crew.start(robots), no_beacons(), Receiver()
    begun = 0.0
    for tick in range(skip + ticks):
        if tick == skip:
            begun = time.perf_counter()
        observations = truth.observe(state)
        received = receiver.receive(observations, beacons, states.contacts.edges)
        states, beacons, twists, _ = crew.step(robots, states, observations.sensed, received)
        state = truth.step(world, state, twists)
    return ticks / (time.perf_counter() - begun)


def main() -> None:
    """Print steps, rates and costs."""
    paper = load(CONFIGS / "paper.toml")
    costs = robot.measure(CONFIGS / "paper.toml")
    print(
        f"crew.step, one robot, about 3 links: {np.median(costs.step) * 1e6:.0f} us"
        "    budget <= 250 us with sub-steps"
    )
    print(f"  decoding: {np.median(costs.decoding) * 1e6:.0f} us, encoding: {np.median(costs.encoding) * 1e6:.0f} us")
    print(f"  the world's tick, 10 robots: {costs.world_tick * 1e6:.0f} us")
    print(f"in process, 10 robots: {rate(paper, 2000, 500):,.0f} ticks/s    budget >= 2,000")
    print("in process, relative neighborhood at constant density:")
    first = None
    for n in SIZES:
        scenario = load(CONFIGS / "hundred.toml", {"robots.count": n, "robots.spacing": SPACING})
        ticks = max(10, min(1000, 200_000 // n))
        per_second = rate(scenario, ticks, ticks // 2)
        cost = 1e6 / per_second / n
        first = cost if n == 100 else first
        flat = f"    {cost / first:.2f}x that of 100 robots (budget <= {FLAT}x)" if first and n > 100 else ""
        print(f"  {n:6,} robots: {per_second * n:11,.0f} robot-ticks/s, {cost:6.2f} us per robot-tick{flat}")
    print("    budget >= 500,000 robot-ticks/s for many robots or stacked runs")


if __name__ == "__main__":
    main()
