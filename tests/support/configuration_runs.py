"""Runs of teams that take up a configuration, and their outcomes: `python -m tests.support.configuration_runs`.

The world and the crew of the product run in one loop. The columns are those of the table of ends in
docs/explanation: times from which the team index stays above a share of its target, ways, separations, connection.
"""

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from agents.configuration.law import State as LawState
from agents.control import crew
from agents.runtime.reception import Receiver
from fes.arrays.types import Floats
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.sensing import no_beacons
from fes.shapes import routes
from fes.shapes.choice import shape
from tests.support.configuration_starts import distances, is_connected, poses
from world.config import scenario as scenarios
from world.config.scenario import Scenario, agent_config
from world.simulation import truth

LIMIT = 5.0
"""Largest speed in the reference table [m/s]."""


class Index(NamedTuple):
    """The team index by its definition, as one program for tests: exp(Phi) with one loss, for a Rayleigh channel."""

    objective: ObjectiveConfig = ObjectiveConfig()
    channel: ChannelConfig = ChannelConfig()

    def coverage(self, separation: Floats) -> Floats:
        """ln c."""
        return np.log(-np.expm1(-((separation / self.objective.minimum_separation) ** self.objective.shape_exponent)))

    def cost(self, separation: Floats) -> Floats:
        """w = -ln q; infinite out of range."""
        channel = self.channel
        threshold = (2.0**channel.spectral_efficiency - 1.0) / channel.reference_snr
        loss = threshold * (separation / channel.reference_distance) ** channel.path_loss_exponent
        reach = (separation / self.objective.maximum_separation) ** self.objective.shape_exponent
        return np.where(separation <= channel.communication_range, loss + reach, np.inf)

    def of(self, positions: Floats) -> float:
        """F of robots at `positions` [n, 2] [m]."""
        n, distance = len(positions), distances(positions)
        crowding = self.coverage(np.where(np.isinf(distance), 1e9, distance)).sum() / n
        cost = self.cost(distance)
        np.fill_diagonal(cost, 0.0)
        delays = [routes.between(routes.relayed(cost, range(n))).mean()]
        if n > 2:
            delays += [routes.between(c, lost).mean() for lost, c in routes.without_each(cost, range(n))]
        return float(np.exp(self.objective.coverage_weight * crowding - max(delays)))

    def best_spacing(self, quality_weight: float) -> float:
        """r_beta [m]: the separation that maximizes ln c + beta ln q, on a grid of 1 mm."""
        grid = np.arange(20.0, self.channel.communication_range, 1e-3)
        return float(grid[np.argmax(self.coverage(grid) - quality_weight * self.cost(grid))])


@lru_cache
def spacing(index: Index, n: int) -> float:
    """r_beta of the patch of `n` robots [m]."""
    return index.best_spacing(shape("lattice", n, 1).quality_weight(1, index.objective.coverage_weight))


@lru_cache
def target(index: Index, n: int) -> float:
    """F of the patch of `n` robots at r_beta."""
    return index.of(spacing(index, n) * shape("lattice", n, 1).slots)


@dataclass
class Moment:
    """The team at one tick."""

    tick: int
    positions: Floats
    """Of the robots present [n, 2] [m]."""
    plans: tuple[Any, ...]
    """Plans of these robots; None for a robot without one."""


def moments(scenario: Scenario) -> Iterator[Moment]:
    """Each tick of a scenario, in one loop."""
    world = truth.create(scenario)
    state, robots = truth.start(world), crew.create(agent_config(scenario), world.ids)
    memory, beacons, receiver, present = crew.start(robots), no_beacons(), Receiver(), state.present
    for tick in range(scenario.ticks):
        if state.present is not present:
            memory = crew.forget(robots, memory, state.present & ~present)
            present = state.present
        observed = truth.observe(state)
        received = receiver.receive(observed, beacons, memory.contacts.edges)
        memory, beacons, twists, _ = crew.step(robots, memory, observed.sensed, received)
        law: LawState = memory.formation
        plans = tuple(plan for plan, is_there in zip(law.plans, present, strict=True) if is_there)
        yield Moment(tick, state.poses[present, :2], plans)
        state = truth.step(world, state, truth.held(state, twists))


@dataclass
class Outcome:
    """The outcome of one run."""

    share: Floats
    """F / target, at each sample."""
    every: float
    """Time between two samples [s]."""
    path: Floats
    """Way of each robot that was there throughout [n] [m]."""
    least: float
    """Smallest separation of two robots at any tick [m]."""
    cut: int
    """Ticks at which the robots were not connected by pairs in range."""
    differing: int
    """Plans that differ from the most common one of their period."""
    contracted: int
    """Periods that began with a contraction."""

    def settled(self, share: float, after: float = 0.0) -> float:
        """Time after `after` [s] from which F / target stays at `share` or above [s]; NaN if it does not."""
        below = np.flatnonzero(self.share < share)
        first = int(below[-1]) + 1 if len(below) else 0
        return max(0.0, first * self.every - after) if first < len(self.share) else np.nan


def watch(scenario: Scenario, index: Index, every: int = 5) -> Outcome:
    """The outcome of a scenario whose formation law is marks and plans; F is computed at each `every` ticks."""
    shares, least, cut, differing, contracted = [], np.inf, 0, 0, 0
    path, before = np.zeros(0), np.zeros((0, 2))
    plans: tuple[Any, ...] = ()
    reach = scenario.channel.communication_range
    for moment in moments(scenario):
        positions = moment.positions
        distance = distances(positions)
        least, cut = min(least, distance.min()), cut + (not is_connected(distance, reach))
        if len(positions) != len(before):
            path, before = np.zeros(len(positions)), positions
        path, before = path + np.hypot(*(positions - before).T), positions
        if moment.tick % every == 0:
            shares.append(index.of(positions) / target(index, len(positions)))
        if any(new is not old for new, old in zip(moment.plans, plans, strict=False)) or not plans:
            made = Counter((p.ids.tobytes(), p.marks.tobytes()) for p in moment.plans if p is not None)
            differing += made.total() - max(made.values(), default=0)
            contracted += any(p is not None and p.kind == 1 for p in moment.plans)
        plans = moment.plans
    return Outcome(np.array(shares), every * scenario.run.dt, path, float(least), cut, differing, contracted)


SEEKING: dict[str, dict[str, Any]] = {
    "oracle": {"index": "oracle", "index_gain": 40000.0, "initial_estimate": [50.0, 90.0]},
    "measured": {"index": "measured", "dither_amplitude": 3.0, "initial_estimate": [80.0, 100.0]},
}
"""Seeking laws, by name; `fixed` gives all robots the best spacing of the team at the start."""


def scenario(
    kind: str, n: int, seed: int, duration: float, index: Index, seeking: str = "oracle", **settings: Any
) -> Scenario:
    """The scenario of a start. `settings` are fields by path, with __ for the dot: `formation__plan_period`."""
    fixed = {"use": "fixed_separation", "separation": spacing(index, n)}
    period = {"plan_period": 4.0, "marks_per_beacon": 16} if n >= 100 else {}
    formation = {
        "configuration": "lattice",
        "rule": "tolerant_relative_neighborhood",
        "linear_limit": LIMIT,
        **period,
    }
    tables = {
        "schema": 1,
        "run": {"dt": 0.02, "duration": duration, "seed": seed},
        "robots": {"poses": [tuple(pose) for pose in poses(kind, n, seed).tolist()]},
        "channel": index.channel.model_dump(),
        "objective": index.objective.model_dump(),
        "seeking": fixed if seeking == "fixed" else SEEKING[seeking],
        "formation": formation,
    }
    paths = {name.replace("__", "."): value for name, value in settings.items()}
    return scenarios.with_overrides(scenarios.parse(tables, kind), paths)


HEADS = ("start", "n", "runs", "end >= .99", "t97 [s]", "t99 [s]", "path [m]", "least [m]", "cut", "differ")


def summary(kind: str, n: int, outcomes: Sequence[Outcome]) -> str:
    """One line of the table: medians and largest values over the runs."""
    good = sum(bool(outcome.share[-1] >= 0.99) for outcome in outcomes)
    times = [np.array([outcome.settled(share) for outcome in outcomes]) for share in (0.97, 0.99)]
    of_times = [f"{np.median(values):.1f}/{values.max():.1f}" for values in times]
    path = f"{np.mean([o.path.mean() for o in outcomes]):.0f}/{max(o.path.max() for o in outcomes):.0f}"
    least = f"{min(o.least for o in outcomes):.1f}"
    cut, differing = sum(o.cut for o in outcomes), sum(o.differing for o in outcomes)
    cells = [kind, n, len(outcomes), good, *of_times, path, least, cut, differing]
    return " | ".join(map(str, cells))


def main() -> None:
    """Print a line for each kind of start."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="+")
    parser.add_argument("-n", type=int, default=10)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--first", type=int, default=1, help="seed of the first run")
    parser.add_argument("--duration", type=float, default=60.0)
    parser.add_argument("--every", type=int, default=5)
    parser.add_argument("--minimum-separation", type=float, default=50.0)
    parser.add_argument("--seeking", choices=["fixed", *SEEKING], default="oracle")
    parser.add_argument("--set", nargs="*", default=[], help="further settings, such as formation.plan_period=1.0")
    arguments = parser.parse_args()
    seeking = arguments.seeking
    settings = {
        path.replace(".", "__"): json.loads(value) for path, _, value in (s.partition("=") for s in arguments.set)
    }
    index = Index(ObjectiveConfig(minimum_separation=arguments.minimum_separation))
    print(*HEADS, sep=" | ", flush=True)
    for kind in arguments.kinds:
        seeds = range(arguments.first, arguments.first + arguments.runs)
        runs = (scenario(kind, arguments.n, seed, arguments.duration, index, seeking, **settings) for seed in seeds)
        print(summary(kind, arguments.n, [watch(run, index, arguments.every) for run in runs]), flush=True)


if __name__ == "__main__":
    main()
