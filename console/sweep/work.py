"""What is handed to a worker, and what it hands back; the same on this machine and on a cluster."""

import math
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from console.backends import inprocess, stacked
from console.sweep.design import SweepRun, Value
from fes.errors import FesError
from world.config.scenario import Scenario

MOST_RUNS, MOST_ROBOTS = 20, 400
"""In one stack: beyond this, more do not make it faster, and the loss by an interruption grows."""

WALL_CLOCK = frozenset({"wall_s", "ticks_per_s", "real_time_factor"})
"""What the summary says of the machine and not of the run."""

THE_SAME = frozenset({"scenario", "seed", "backend", "arithmetic"})
"""What a sweep says elsewhere, or what is the same for all its runs."""

Scalars = dict[str, Value]


@dataclass(frozen=True)
class Done:
    """A run that was carried out."""

    key: str
    scalars: Scalars
    """The summary's numbers by dotted name; empty where the run failed."""
    error: str | None = None
    """Why the run failed: the same, however often it is repeated."""


@dataclass(frozen=True)
class Batch:
    """Runs that one worker carries out together: they are alike."""

    name: str
    keys: tuple[str, ...]
    scenarios: tuple[Scenario, ...]


Watch = Callable[[int], None]
"""Called from time to time with the ticks that are done, of all runs together."""


def ignore(ticks: int) -> None:
    """A Watch that does nothing."""


@dataclass(frozen=True)
class Workers:
    """Who carries out batches, wherever they are."""

    count: int
    """How many batches they carry out at a time."""
    carry_out: Callable[[Sequence[Batch], Watch], Generator[list[Done], None, None]]
    """Yields the results of each batch as it ends; Watch is called meanwhile."""


def batches(name: str, runs: Sequence[SweepRun], workers: int) -> list[Batch]:
    """The runs in batches that are alike, as many as keep all workers busy to the end."""
    groups: list[tuple[Any, list[SweepRun]]] = []
    cell = None
    for run in runs:
        if run.cell != cell:
            cell, likeness = run.cell, stacked.alike(run.scenario)
            processes = next((group for other, group in groups if other == likeness), None)
            if processes is None:
                groups.append((likeness, processes := []))
        assert processes is not None
        processes.append(run)
    return [batch for _, group in groups for batch in _cut(name, group, workers)]


def carry_out(batch: Batch, watch: Watch = ignore) -> list[Done]:
    """Run a batch. An error in one run is that run's: then each is run by itself."""
    with np.errstate(all="ignore"):  # a number that is not finite ends a run with an error, or is in its row
        try:
            summaries = stacked.run(batch.scenarios, batch.name, watch)
        except FesError:
            return [_alone(batch.name, key, one) for key, one in zip(batch.keys, batch.scenarios, strict=True)]
    return [Done(key, scalars(found)) for key, found in zip(batch.keys, summaries, strict=True)]


def scalars(summary: dict[str, Any], prefix: str = "") -> Scalars:
    """The scalars of a summary by dotted name, without what depends on the machine.

    >>> scalars({"ticks": 5, "wall_s": 0.3, "edges": [[0, 1]], "time_to": {"estimate_1m": None}})
    {'ticks': 5, 'time_to.estimate_1m': None}
    """
    found: Scalars = {}
    for name, value in summary.items():
        if prefix + name in WALL_CLOCK | THE_SAME:
            continue
        if isinstance(value, list) and value and isinstance(value[0], dict):
            value = {str(at): one for at, one in enumerate(value)}
        if isinstance(value, dict):
            found |= scalars(value, f"{prefix}{name}.")
        elif not isinstance(value, list | tuple):
            found[prefix + name] = value
    return found


def _alone(name: str, key: str, scenario: Scenario) -> Done:
    try:
        return Done(key, scalars(inprocess.run(scenario, name)))
    except FesError as error:
        return Done(key, {}, str(error))


def _cut(name: str, runs: list[SweepRun], workers: int) -> Iterator[Batch]:
    """Equal shares: each as large as a stack may be, and a number of them that the workers divide evenly."""
    robots = sum(run.scenario.robots.number for run in runs) / len(runs)
    most = max(1, min(MOST_RUNS, int(MOST_ROBOTS / robots)))
    count = min(len(runs), workers * math.ceil(len(runs) / most / workers))
    for at in range(count):
        share = runs[at * len(runs) // count : (at + 1) * len(runs) // count]
        yield Batch(name, tuple(run.key for run in share), tuple(run.scenario for run in share))
