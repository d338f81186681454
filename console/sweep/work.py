"""Batches for workers, and their results, on this machine and on a cluster."""

import contextlib
import itertools
import math
from collections.abc import Callable, Container, Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from console.backends import inprocess, stacked
from console.sweep.design import Design, SweepRun, Value
from console.terminal import counting
from console.terminal.counting import Watch
from fes.errors import FesError
from fes.extension import registry
from fes.extension.evidence import Evidence
from world.config.outside import extensions
from world.config.scenario import Scenario

MOST_RUNS, MOST_ROBOTS = 20, 400
"""Maximum size of a stack; a larger stack is not faster, and loses more in an interruption."""

WALL_CLOCK = frozenset({"wall_s", "ticks_per_s", "real_time_factor"})
"""Keys of the summary that describe the machine, not the run."""

THE_SAME = frozenset({"scenario", "seed", "backend", "arithmetic"})
"""Keys of the summary that a sweep stores elsewhere, or that are equal for all its runs."""

Scalars = dict[str, Value]


@dataclass(frozen=True)
class Done:
    """Result of a run."""

    key: str
    scalars: Scalars
    """The summary's numbers by dotted name; empty where the run failed."""
    error: str | None = None
    """Error of a failed run; a repetition gives the same error."""


@dataclass(frozen=True)
class Batch:
    """Similar runs that one worker carries out together."""

    name: str
    keys: tuple[str, ...]
    scenarios: tuple[Scenario, ...]
    use: tuple[str, ...] = ()
    """Modules of extensions that the worker may load."""
    extensions: tuple[Evidence, ...] = ()
    """The extensions, of which the worker must have the same source."""


@dataclass(frozen=True)
class Workers:
    """Workers on this machine or a cluster."""

    count: int
    """Number of batches carried out at a time."""
    carry_out: Callable[[Sequence[Batch], Watch], Generator[list[Done], None, None]]
    """Yields the results of each batch at its end, and calls the Watch periodically with the ticks of all batches."""


def finish(
    design: Design,
    done: Container[str],
    store: Callable[[list[Done]], None],
    workers: Workers,
    watch: Callable[[int, int], None],
) -> None:
    """Carry out all runs of a design whose keys are not `done`, and `store` their results batch by batch.

    `watch` is called periodically with the completed ticks and the completed runs, the earlier ones included.
    """
    missing = [run for run in design.runs if run.key not in done]
    finished = len(design.runs) - len(missing)
    before = sum(run.scenario.ticks for run in design.runs) - sum(run.scenario.ticks for run in missing)
    watch(before, finished)
    ended = workers.carry_out(
        batches(design.name, missing, workers.count), lambda ticks: watch(before + ticks, finished)
    )
    with contextlib.closing(ended):
        for results in ended:
            store(results)
            finished += len(results)


def batches(name: str, runs: Sequence[SweepRun], workers: int) -> list[Batch]:
    """Batches of similar runs, as many as keep all workers busy to the end."""
    groups: list[tuple[Any, list[SweepRun]]] = []
    cell = None
    for run in runs:
        if run.cell != cell:
            cell, likeness = run.cell, stacked.alike(run.scenario)
            matching = next((group for known, group in groups if known == likeness), None)
            if matching is None:
                groups.append((likeness, matching := []))
        assert matching is not None
        matching.append(run)
    return [batch for _, group in groups for batch in _cut(name, group, workers)]


def carry_out(batch: Batch, watch: Watch = counting.ignore) -> list[Done]:
    """Run a batch as one stack; after an error, run by run, so that only the faulty run fails.

    `watch` is called with the completed ticks of the batch, and begins anew after an error.
    """
    for module in batch.use:
        registry.use(module)
    extensions.check_recorded([entry.table for entry in batch.extensions], "the sweep")
    with np.errstate(all="ignore"):  # numbers that are not finite end a run or appear in its row
        try:
            summaries = stacked.run(batch.scenarios, batch.name, watch)
        except FesError:
            watches = counting.parts(watch, *(scenario.ticks for scenario in batch.scenarios))
            return list(map(_alone, itertools.repeat(batch.name), batch.keys, batch.scenarios, watches))
    return [Done(key, scalars(summary)) for key, summary in zip(batch.keys, summaries, strict=True)]


def scalars(summary: dict[str, Any], prefix: str = "") -> Scalars:
    """The scalars of a summary by dotted name, without those that depend on the machine.

    >>> scalars({"ticks": 5, "wall_s": 0.3, "edges": [[0, 1]], "time_to": {"estimate_1m": None}})
    {'ticks': 5, 'time_to.estimate_1m': None}
    """
    flat: Scalars = {}
    for name, value in summary.items():
        if prefix + name in WALL_CLOCK | THE_SAME:
            continue
        if isinstance(value, list) and value and isinstance(value[0], dict):
            value = {str(index): entry for index, entry in enumerate(value)}
        if isinstance(value, dict):
            flat |= scalars(value, f"{prefix}{name}.")
        elif not isinstance(value, list | tuple):
            flat[prefix + name] = value
    return flat


def _alone(name: str, key: str, scenario: Scenario, watch: Watch) -> Done:
    try:
        return Done(key, scalars(inprocess.run(scenario, name, collect=lambda tick: watch(tick.state.tick + 1))))
    except FesError as error:
        return Done(key, {}, str(error))


def _cut(name: str, runs: list[SweepRun], workers: int) -> Iterator[Batch]:
    """Equal shares, none larger than a stack, in a number that the workers divide evenly."""
    robots = sum(run.scenario.robots.number for run in runs) / len(runs)
    most = max(1, min(MOST_RUNS, int(MOST_ROBOTS / robots)))
    count = min(len(runs), workers * math.ceil(len(runs) / most / workers))
    for index in range(count):
        share = runs[index * len(runs) // count : (index + 1) * len(runs) // count]
        cells = {run.cell: run.scenario for run in share}
        evidence = dict.fromkeys(entry for scenario in cells.values() for entry in extensions.of(scenario))
        keys, scenarios = tuple(run.key for run in share), tuple(run.scenario for run in share)
        yield Batch(name, keys, scenarios, registry.used(), tuple(evidence))
