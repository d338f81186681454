"""Runs of teams that take up a configuration, and their outcomes: `python -m tests.support.configuration_runs`.

The world and the crew of the product run in one loop. The columns are those of the table of ends in
docs/explanation: times from which the team index stays above a share of its target, ways, separations, connection.
"""

import argparse
import json
import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.configuration.law import State as LawState
from agents.configuration.planning import CONTRACT, Plan
from agents.control import crew
from agents.runtime.reception import Receiver
from fes.arrays.types import Floats
from fes.model.config import TOLERANT
from fes.model.sensing import no_beacons
from tests.support.configuration_starts import distances, is_connected, poses
from world.config import scenario as scenarios
from world.config.scenario import Scenario, agent_config
from world.metrics.team import target
from world.simulation import reception, truth

LIMIT = 5.0
"""Largest speed in the reference table [m/s]."""


@dataclass
class Moment:
    """The team at one tick."""

    tick: int
    positions: Floats
    """Of the robots present [n, 2] [m]."""
    plans: dict[int, Plan | None]
    """Plans of these robots, by id; None for a robot without one."""
    epochs: dict[int, int]
    """Periods of their clocks, by id."""


def moments(scenario: Scenario, noise: float = 0.0) -> Iterator[Moment]:
    """Each tick of a scenario, in one loop. Each robot senses its position with normal `noise` [m] in x and y."""
    random = np.random.default_rng([scenario.run.seed, 9])
    world = truth.create(scenario)
    state, robots = truth.start(world), crew.create(agent_config(scenario), world.ids)
    memory, beacons, receiver, present = crew.start(robots), no_beacons(), Receiver(), state.present
    for tick in range(scenario.ticks):
        if state.present is not present:
            memory = crew.forget(robots, memory, state.present & ~present)
            present = state.present
        observed = truth.observe(state)
        received = receiver.receive(observed, beacons, memory.contacts.edges)
        sensed = observed.sensed
        if noise > 0.0:
            error = np.zeros_like(sensed.poses)
            error[:, :2] = random.normal(0.0, noise, error[:, :2].shape)
            sensed = sensed._replace(poses=sensed.poses + error)
        memory, beacons, twists, _ = crew.step(robots, memory, sensed, received)
        law: LawState = memory.formation
        ids = np.flatnonzero(present).tolist()
        plans, epochs = {robot: law.plans[robot] for robot in ids}, {robot: int(law.epoch[robot]) for robot in ids}
        yield Moment(tick, state.poses[present, :2], plans, epochs)
        state = truth.step(world, state, truth.held(state, twists))


@dataclass
class Outcome:
    """The outcome of one run."""

    share: Floats
    """F / target, at each sample."""
    every: float
    """Time between two samples [s]."""
    path: Floats
    """Way of each robot since the last death or joiner [n] [m]."""
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


def watch(scenario: Scenario, every: int = 5, noise: float = 0.0) -> Outcome:
    """The outcome of a scenario whose formation law is marks and plans; F is computed at each `every` ticks.

    `noise` [m] is that of the positions that robots sense.
    """
    shares, least, cut = [], np.inf, 0
    path, before = np.zeros(0), np.zeros((0, 2))
    made: dict[int, Counter[tuple[int, bytes, bytes]]] = defaultdict(Counter)
    epochs: dict[int, int] = {}
    best: dict[int, float] = {}
    reach, context = scenario.channel.communication_range, reception.context(scenario)
    for moment in moments(scenario, noise):
        positions = moment.positions
        distance = distances(positions)
        least, cut = min(least, distance.min()), cut + (not is_connected(distance, reach))
        if moment.epochs.keys() != epochs.keys():
            path, before = np.zeros(len(positions)), positions
        path, before = path + np.hypot(*(positions - before).T), positions
        if moment.tick % every == 0:
            index = target.of_positions(positions, scenario.channel, context)
            assert index is not None
            n = len(positions)
            best[n] = best.get(n) or target.target(n, scenario.formation, scenario.channel, context)
            shares.append(index.value / best[n])
        for robot, plan in moment.plans.items():
            if plan is not None and epochs.get(robot) != moment.epochs[robot]:
                made[moment.epochs[robot]][plan.kind, plan.ids.tobytes(), plan.marks.tobytes()] += 1
        epochs = moment.epochs
    differing = sum(plans.total() - max(plans.values()) for plans in made.values())
    contracted = sum(any(kind == CONTRACT for kind, _, _ in plans) for plans in made.values())
    return Outcome(np.array(shares), every * scenario.run.dt, path, float(least), cut, differing, contracted)


SEEKING: dict[str, dict[str, Any]] = {
    "oracle": {"index": "oracle", "index_gain": 40000.0, "initial_estimate": [50.0, 90.0]},
    "measured": {
        "index": "measured",
        "reference_separation": 75.0,
        "dither_amplitude": 3.0,
        "dither_frequency": math.pi / 10.0,
        "consensus_gain": 4.0,
        "initial_estimate": [80.0, 100.0],
    },
}
"""Seeking laws, by name; `fixed` gives all robots the best spacing of the team at the start."""


def scenario(kind: str, n: int, seed: int, duration: float, seeking: str = "oracle", **settings: Any) -> Scenario:
    """The scenario of a start. `settings` are fields by path, with __ for the dot: `formation__plan_period`."""
    period = {"plan_period": 4.0, "marks_per_beacon": 16} if n >= 100 else {}
    tables = {
        "schema": 1,
        "run": {"dt": 0.02, "duration": duration, "seed": seed},
        "robots": {"poses": [tuple(pose) for pose in poses(kind, n, seed).tolist()]},
        "seeking": SEEKING["oracle" if seeking == "fixed" else seeking],
        "formation": {"configuration": "lattice", "rule": TOLERANT, "linear_limit": LIMIT, **period},
    }
    paths = {name.replace("__", "."): value for name, value in settings.items()}
    what = scenarios.with_overrides(scenarios.parse(tables, kind), paths)
    if seeking == "fixed":
        fixed = {"use": "fixed_separation", "separation": spacing(what, n)}
        what = scenarios.parse({**what.model_dump(by_alias=True), "seeking": fixed}, kind)
    return what


def spacing(what: Scenario, n: int) -> float:
    """r_beta of the configuration of `n` robots [m]."""
    shape = target.shape_of(n, what.formation, what.objective.losses)
    assert shape is not None
    return target.spacing(shape, what.channel, reception.context(what))


def with_events(what: Scenario, at: float, dying: int, joining: int, joining_at: float | None = None) -> Scenario:
    """The scenario in which so many random robots die `at` [s], and so many more join, 20 to 100 m off the patch.

    They join at the same time, or at `joining_at` [s].
    """
    n, random = what.robots.number, np.random.default_rng([what.run.seed, 7])
    assert what.robots.poses is not None
    starts = np.array(what.robots.poses)
    center, shape = starts[:, :2].mean(axis=0), target.shape_of(n, what.formation, what.objective.losses)
    assert shape is not None
    joiners = []
    for angle in random.uniform(-np.pi, np.pi, joining):
        way = shape.reach * spacing(what, n) + random.uniform(20.0, 100.0)
        x, y = center + way * np.array([np.cos(angle), np.sin(angle)])
        joiners.append((float(x), float(y), float(angle)))
    ids = list(range(n, n + joining))
    dead = random.permutation(n)[:dying].tolist()
    events = [{"at": 0.0, "kill": ids}] if ids else []
    if joining_at is None:
        events.append({"at": at, "kill": dead, "restart": ids})
    else:
        events += [{"at": at, "kill": dead}, {"at": joining_at, "restart": ids}]
    everybody = [tuple(pose) for pose in [*starts.tolist(), *joiners]]
    return scenarios.with_overrides(what, {"robots.poses": everybody, "event": events})


HEADS = ("start", "n", "runs", "end >= .99", "t97 [s]", "t99 [s]", "path [m]", "least [m]", "cut", "differ")


def summary(kind: str, n: int, outcomes: Sequence[Outcome], after: float = 0.0) -> str:
    """One line of the table: medians and largest values over the runs, times since `after` [s]."""
    good = sum(bool(outcome.share[-1] >= 0.99) for outcome in outcomes)
    times = [np.array([outcome.settled(share, after) for outcome in outcomes]) for share in (0.97, 0.99)]
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
    parser.add_argument("--minimum-separation", type=float)
    parser.add_argument("--seeking", choices=["fixed", *SEEKING], default="oracle")
    parser.add_argument("--die", type=int, default=0, help="robots that die at the time `--at`")
    parser.add_argument("--join", type=int, default=0, help="robots that join at the time `--at`")
    parser.add_argument("--at", type=float, default=0.0, help="[s]")
    parser.add_argument("--noise", type=float, default=0.0, help="of sensed positions [m]")
    parser.add_argument("--set", nargs="*", default=[], help="further settings, such as formation.plan_period=1.0")
    arguments = parser.parse_args()
    seeking = arguments.seeking
    settings = {
        path.replace(".", "__"): json.loads(value) for path, _, value in (s.partition("=") for s in arguments.set)
    }
    if arguments.minimum_separation:
        settings["objective__minimum_separation"] = arguments.minimum_separation
    print(*HEADS, sep=" | ", flush=True)
    for kind in arguments.kinds:
        runs = [
            scenario(kind, arguments.n, arguments.first + run, arguments.duration, seeking, **settings)
            for run in range(arguments.runs)
        ]
        if arguments.die or arguments.join:
            runs = [with_events(run, arguments.at, arguments.die, arguments.join) for run in runs]
        outcomes = [watch(run, arguments.every, arguments.noise) for run in runs]
        print(summary(kind, arguments.n, outcomes, arguments.at), flush=True)


if __name__ == "__main__":
    main()
