"""fes.run and fes.read: a scenario or a log to a Run."""

import contextlib
import math
import os
import shutil
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from console.api import arguments, background, display, scenarios
from console.api.background import Work
from console.api.collector import TickCollector
from console.api.display import Progress, Show
from console.api.result import Run
from console.api.scenarios import NamedScenario, Overrides, Source
from console.backends import inprocess, processes, view
from console.backends.inprocess import Tick
from console.backends.processes import Launch
from console.connect import run_directory
from console.connect.run_directory import RunDirectory
from console.replay import log, recorded, reexecution
from console.replay.log import Log
from fes.command_line import SLOWEST
from fes.errors import FesError, ScenarioError, Stopped
from fes.recording.layout import NAME
from world.config import remarks
from world.config.outside import extensions
from world.execution.recorder import Recorder
from world.metrics.collector import MetricsCollector
from world.metrics.summary import write, write_scenario
from world.metrics.team import target
from world.simulation import crowd

Backend = Literal["inprocess", "processes"]


def run(
    scenario: Source,
    seed: int | None = None,
    *,
    duration: float | None = None,
    overrides: Overrides | None = None,
    backend: Backend = "inprocess",
    out: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    name: str | None = None,
    rtf: float | None = None,
    agents_per_process: int = 1,
    use: Iterable[str] = (),
) -> Run:
    """Run a scenario to its end.

    Arguments:
        scenario: a Scenario, the name of a built-in scenario, or the path of a file.
        seed: overrides `run.seed`.
        duration: overrides `run.duration` [s].
        overrides: further fields, as in `fes.load`.
        backend: "inprocess" for world and robots in one loop, or "processes" for one process per agent, as `fes run`
            starts them. Both give the same digits.
        out: a new or empty run directory for `scenario.toml`, `summary.json` and `run.mcap`; None stores nothing.
        progress: None for a bar if standard error is a terminal, or in a notebook; False for none. A function is
            called with the completed ticks and all ticks, ten times per second.
        name: name of the scenario in summary and log (default: that of its file).
        rtf: simulated seconds per second of wall clock; None for full speed.
        agents_per_process: robots that each agent hosts, with backend "processes".
        use: modules whose extensions the scenario may name, as in `fes.load`.

    A KeyboardInterrupt ends the run after its present tick. A run directory then holds the results so far, which
    `fes.read` reads. Remarks on the scenario, such as a field without effect, are warnings.

    Raises FesError, one line; ScenarioError for an invalid scenario or argument.
    """
    with arguments.checked():
        arguments.allow(use)
        fields = scenarios.flat(overrides) | _given({"run.seed": seed, "run.duration": duration})
        to_run = scenarios.resolve(scenario, fields, name)
        launch = _launch(to_run, backend, rtf, agents_per_process)
        for line in [*remarks.of(to_run.scenario), *target.remarks(to_run.scenario)]:
            warnings.warn(line, stacklevel=2)
        work, directory = Work(to_run.scenario.ticks), None if out is None else Path(out)
        with display.shown(progress, to_run.name, work.total) as show:
            if backend == "inprocess":
                return background.call(work, lambda: _in_one_loop(to_run, work, directory, rtf), show)
            return background.call(work, lambda: _in_processes(to_run, work, directory, launch, show), show)


def read(run_dir_or_log: str | os.PathLike[str], *, progress: Progress = None, use: Iterable[str] = ()) -> Run:
    """Read a recorded run from its run directory or its log, such as "runs/latest" or "run.mcap".

    The run is executed again from its messages and compared with the log. So the arrays are those of the run, to the
    bit. If the run was killed, its log has no end: its complete ticks are returned, with a warning. `progress` and
    `use` are those of `fes.run`. An extension whose source has changed is an error. The log of an earlier fes with
    other elementary functions is not compared. A warning names both versions, since the last digits may differ.

    Raises FesError, one line, if the log is missing or damaged, or if the second execution differs from it.
    """
    with arguments.checked():
        arguments.allow(use)
        target, work = Path(run_dir_or_log), Work()

        def gather() -> tuple[Log, Run]:
            logged = log.load(target)
            extensions.check(logged.scenario, logged.extensions, str(logged.path))
            work.total = logged.scenario.ticks
            return logged, _gather(logged, work.reach)

        with display.shown(progress, str(target), work.total) as show:
            logged, finished = background.call(work, gather, show)
        if (note := recorded.other_digits(logged)) is not None:
            warnings.warn(note, stacklevel=2)
        if logged.ended is None:
            ticks = f"{len(finished.time)} of {logged.scenario.ticks} ticks are there"
            warnings.warn(f"{logged.path} has no end, its run was killed or the file was cut: {ticks}", stacklevel=2)
        return finished


def _given(fields: dict[str, Any]) -> dict[str, Any]:
    """The fields that were given, with values of TOML."""
    return scenarios.flat({field: value for field, value in fields.items() if value is not None})


def _launch(to_run: NamedScenario, backend: str, rtf: float | None, agents_per_process: int) -> Launch:
    """Settings of a run with processes; raises FesError for an invalid argument of `run`."""
    scenario = to_run.scenario
    crowd.check(scenario)
    if rtf is not None and not SLOWEST <= rtf < math.inf:
        raise ScenarioError("rtf", f"expects a number that is at least {SLOWEST:g}, or None, got {rtf!r:.40}")
    if agents_per_process < 1:
        raise ScenarioError("agents_per_process", f"expects at least 1, got {agents_per_process!r:.40}")
    launch = Launch(to_run.name, agents_per_process, "max" if rtf is None else str(rtf), dashboard=False, record=True)
    if backend == "inprocess":
        inprocess.check(scenario)
    elif backend != "processes":
        raise ScenarioError("backend", f"expects 'inprocess' or 'processes', got {backend!r:.40}")
    else:
        processes.check(launch, scenario)
        if scenario.run.clock == "live" and rtf is not None:
            raise ScenarioError("rtf", "does not go with the live clock, which follows the wall clock")
    return launch


def _in_one_loop(to_run: NamedScenario, work: Work, out: Path | None, rtf: float | None) -> Run:
    name, scenario = to_run
    collector, begun = TickCollector(scenario.robots.number), time.perf_counter()

    def collect(tick: Tick) -> None:
        collector.add(tick.state, tick.twists, tick.telemetry)
        work.reach(tick.state.tick + 1)
        if rtf is not None:  # an interrupt ends this pause
            work.pause(begun + (tick.state.tick + 1) * scenario.run.dt / rtf - time.perf_counter())

    if out is None:
        return collector.run(scenario, inprocess.run(scenario, name, collect=collect), None)
    with run_directory.created(name, out) as directory:
        write_scenario(directory.path, scenario)
        with Recorder(directory.path / NAME, scenario, name, "inprocess") as recorder:

            def store(summary: dict[str, Any]) -> None:
                write(directory.path, summary)
                recorder.conclude(summary)

            summary = inprocess.run(scenario, name, keep=store, recorder=recorder, collect=collect)
    return collector.run(scenario, summary, out)


def _in_processes(to_run: NamedScenario, work: Work, out: Path | None, launch: Launch, show: Show | None) -> Run:
    """The run that the log of the processes holds; the log is temporary without `out`."""
    with _stored(to_run.name, out) as directory:
        write_scenario(directory.path, to_run.scenario)
        watched = None if show is None else view.of_reports(lambda report: work.reach(report.tick + 1))
        processes.run(launch, to_run.scenario, directory, watched, work.supervise)
        finished = _gather(log.load(directory.path), lambda ticks: work.check())
    return replace(finished, directory=out)


@contextlib.contextmanager
def _stored(name: str, out: Path | None) -> Iterator[RunDirectory]:
    """A run directory; without `out` a temporary one, which remains only if the run fails: errors name its files."""
    path = Path(tempfile.mkdtemp(prefix="fes-")) if out is None else out
    try:
        with run_directory.created(name, path) as directory:
            yield directory
    except Stopped:
        if out is not None:
            raise
        shutil.rmtree(path, ignore_errors=True)
        raise Stopped(background.INTERRUPTED) from None
    except FesError:
        with contextlib.suppress(OSError):  # the logs of the processes are in it
            path.rmdir()
        raise
    if out is None:
        shutil.rmtree(path, ignore_errors=True)


def _gather(logged: Log, reach: Callable[[int], None]) -> Run:
    """The run of a log; `reach` is called with the completed ticks after each tick."""
    collector, last = TickCollector(logged.scenario.robots.number), MetricsCollector(logged.scenario)
    for moment, metrics in reexecution.viewed(logged):
        last = metrics
        collector.add(moment.state, moment.twists, moment.telemetry)
        reach(moment.state.tick + 1)
    summary = logged.summary if logged.summary is not None else reexecution.summary(logged, last)
    return collector.run(logged.scenario, summary, logged.path.parent)
