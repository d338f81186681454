"""fes.sweep: many runs of a scenario, as a table."""

import operator
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from console.api import arguments, background, display, scenarios
from console.api.background import Work
from console.api.display import Progress
from console.api.scenarios import Overrides, Source
from console.api.sweep_table import ResultTable, SweepTable
from console.sweep import cluster, design, ledger, local, work
from console.sweep.design import Design
from console.sweep.results import Results
from console.sweep.work import Done, Workers
from fes.errors import FesError, ScenarioError, Stopped, reason
from world.config.scenario import Scenario


def sweep(
    scenario: Source,
    axes: Mapping[str, Iterable[Any]] | None = None,
    *,
    seeds: Iterable[int],
    overrides: Overrides | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    out: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    name: str | None = None,
    use: Iterable[str] = (),
) -> SweepTable:
    """Run a scenario with every combination of the axes' values, each with the same seeds.

    Arguments:
        scenario: a Scenario, the name of a built-in scenario, or the path of a file.
        axes: values of fields by dotted path, such as {"formation.rule": ["disk", "two_nearest"]}.
        seeds: values of `run.seed`, such as range(20).
        overrides: fields of all runs, as in `fes.load`.
        jobs: worker processes (default: one per core).
        scheduler: address of a Dask cluster instead, such as "tcp://10.0.0.1:8786".
        out: directory for the tables and the finished runs, from which the same call resumes; None stores nothing.
        progress: as in `fes.run`; the ticks are those of all runs.
        name: name of the scenario in messages and in `out` (default: that of its file).
        use: modules whose extensions the scenario may name, as in `fes.load`.

    A run that fails has its error in the column `error`. The table takes about 2 kB per run. A KeyboardInterrupt ends
    the workers and is raised.

    Raises FesError, one line; ScenarioError for an invalid scenario or argument.
    """
    with arguments.checked():
        arguments.allow(use)
        if jobs is not None and (scheduler is not None or jobs < 1):
            raise ScenarioError("jobs", "expects at least 1 worker process, without a scheduler")
        planned = _plan(scenario, axes or {}, seeds, scenarios.flat(overrides), name)
        task = Work(sum(run.scenario.ticks for run in planned.runs))
        workers = local.hired(jobs or local.cores()) if scheduler is None else cluster.connected(scheduler)
        directory = None if out is None else Path(out)

        def carry_out() -> dict[str, Done]:
            with workers as hired:
                return _carry_out(planned, hired, task, directory)

        with display.shown(progress, planned.name, task.total) as show:
            results = Results.of(planned, background.call(task, carry_out, show))
        if directory is not None:
            try:
                results.write(directory)
            except OSError as error:
                raise FesError(f"cannot write the tables: {reason(error)}") from None
        return SweepTable(
            results.rows,
            {field: planned.values(index) for index, field in enumerate(planned.axes)},
            planned.seeds,
            ResultTable(results.cell_rows()),
            ResultTable(results.difference_rows()),
        )


def _plan(
    source: Source, axes: Mapping[str, Iterable[Any]], seeds: Iterable[int], fixed: dict[str, Any], name: str | None
) -> Design:
    """The design of the sweep; raises ScenarioError."""
    fields = {field: [scenarios.plain(value, field) for value in _values(field, axes[field])] for field in axes}
    base = scenarios.resolve(source, fixed, name)

    def make(settings: dict[str, Any]) -> Scenario:
        return scenarios.resolve(source, settings).scenario

    return design.crossed(base.name, make, fixed, fields, _seeds(seeds), scenarios.comparison(source))


def _values(axis: str, values: Iterable[Any]) -> list[Any]:
    if isinstance(values, str) or not isinstance(values, Iterable) or not (listed := list(values)):
        raise ScenarioError("axes", f"'{axis}' expects a list of values, got {values!r:.40}")
    return listed


def _seeds(seeds: Iterable[int]) -> list[int]:
    """The seeds, checked as those of fes sweep; raises ScenarioError."""
    try:
        if isinstance(seeds, range) and len(seeds) > design.MAX_RUNS:
            raise ScenarioError("seeds", f"lists at most {design.MAX_RUNS} seeds, got {seeds!r}")
        return design.parse_seeds(",".join(str(operator.index(seed)) for seed in seeds))
    except TypeError:
        raise ScenarioError("seeds", f"expects whole numbers, such as range(20), got {seeds!r:.40}") from None


def _carry_out(planned: Design, workers: Workers, task: Work, out: Path | None) -> dict[str, Done]:
    """The results of all runs by their keys."""

    def watch(ticks: int, runs: int) -> None:
        task.reach(ticks)

    if out is None:
        done: dict[str, Done] = {}
        work.finish(planned, done, lambda results: done.update({run.key: run for run in results}), workers, watch)
        return done
    with ledger.opened(out, planned) as finished:
        try:
            work.finish(planned, finished.done, finished.add, workers, watch)
        except Stopped as stopped:
            ready = sum(run.key in finished.done for run in planned.runs)
            raise Stopped(
                f"{stopped}: {ready} of {len(planned.runs)} runs are done; the same call resumes the sweep"
            ) from None
        return finished.done
