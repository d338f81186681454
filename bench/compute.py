"""What the laws cost: one robot's step, in-process rates, and the cost per robot-tick as the team grows."""

import time
from pathlib import Path
from typing import Any

import numpy as np

from agents import crew
from fes.sensing import silence
from world import simulation
from world.scenario import Scenario, agent_config, load

CONFIGS = Path("configs")
SIZES = (10, 100, 1_000, 10_000)
SPACING = 78.0


def rate(scenario: Scenario, ticks: int, skip: int) -> float:
    """In-process ticks per second over `ticks` ticks, after `skip`."""
    world = simulation.create(scenario)
    state = simulation.start(world)
    robots = crew.assemble(agent_config(scenario), world.ids)
    minds, said = crew.start(robots), silence()
    begun = 0.0
    for tick in range(skip + ticks):
        if tick == skip:
            begun = time.perf_counter()
        minds, said, twists = crew.step(robots, minds, simulation.observe(state), said)
        state = simulation.step(world, state, twists)
    return ticks / (time.perf_counter() - begun)


def one_robot(scenario: Scenario, ticks: int, skip: int) -> tuple[float, float]:
    """Median time [s] of `crew.step` for a crew of one, over all robots, and the mean number of links."""
    world = simulation.create(scenario)
    state = simulation.start(world)
    config = agent_config(scenario)
    everybody = crew.assemble(config, world.ids)
    alone = [crew.assemble(config, np.array([robot])) for robot in world.ids.tolist()]
    minds, said = crew.start(everybody), silence()
    lone_minds = [crew.start(one) for one in alone]
    times, links = [], []
    for tick in range(skip + ticks):
        observations = simulation.observe(state)
        for robot, one in enumerate(alone):
            mine = type(observations)(
                observations.tick,
                observations.poses[robot : robot + 1],
                _own(observations.in_range, robot, one.ids),
                observations.reception[observations.in_range.spans[robot]],
            )
            begun = time.perf_counter()
            lone_minds[robot], _, _ = crew.step(one, lone_minds[robot], mine, said)
            if tick >= skip:
                times.append(time.perf_counter() - begun)
        minds, said, twists = crew.step(everybody, minds, observations, said)
        links.append(len(said.links) / len(world.ids))
        state = simulation.step(world, state, twists)
    return float(np.median(times)), float(np.mean(links))


_kept: dict[tuple[int, int], Any] = {}


def _own(edges: Any, robot: int, ids: Any) -> Any:
    """One robot's part of the pairs in range; the same object while they stay the same, as in a process."""
    if _kept.get((robot, 0)) is not edges:
        span = edges.spans[robot]
        part = type(edges)(ids, np.zeros(span.stop - span.start, dtype=np.int64), edges.peers[span])
        _kept[robot, 0], _kept[robot, 1] = edges, part
    return _kept[robot, 1]


def main() -> None:
    """Print them all."""
    paper = load(CONFIGS / "paper.toml")
    cost, links = one_robot(paper, 200, 400)
    print(f"crew.step, one robot with {links:.1f} links: {cost * 1e6:.0f} us    budget <= 250 us")
    print(f"in process, 10 robots: {rate(paper, 2000, 500):,.0f} ticks/s    budget >= 2,000")
    print("in process, relative neighborhood at constant density:")
    first = None
    for n in SIZES:
        scenario = load(CONFIGS / "hundred.toml", {"robots.count": n, "robots.spacing": SPACING})
        ticks = max(10, min(1000, 200_000 // n))
        per_second = rate(scenario, ticks, ticks // 2)
        cost = 1e6 / per_second / n
        first = cost if n == 100 else first
        flat = f"    {cost / first:.2f}x that of 100 robots (budget <= 2x)" if first and n > 100 else ""
        print(f"  {n:6,} robots: {per_second * n:11,.0f} robot-ticks/s, {cost:6.2f} us a robot-tick{flat}")
    print("    budget >= 500,000 robot-ticks/s for many robots or stacked runs")


if __name__ == "__main__":
    main()
