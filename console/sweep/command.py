"""The command fes sweep, from its arguments to its files."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from console.analysis import figures
from console.connect.options import SET, Scenario, Use
from console.sweep import cluster, design, ledger, local, picture, report, table, work
from console.sweep.design import Design
from console.sweep.ledger import Ledger
from console.sweep.results import Results
from console.sweep.schemes import outcomes
from console.sweep.schemes import picture as scheme_picture
from console.sweep.schemes import report as scheme_report
from console.sweep.table import Format
from console.sweep.work import Workers
from console.terminal import printing, progress
from fes import process
from fes.errors import FesError, ScenarioError, Stopped, reason
from world.config import builtin, remarks

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def sweep(
    scenario: Scenario,
    seeds: Annotated[str, typer.Option(metavar="A:B", help="Seeds A to B - 1, or a list such as 1,2,5.")],
    axis: Annotated[
        list[str] | None, typer.Option(metavar="A.B=V,W", help="A field and its values; several axes are crossed.")
    ] = None,
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="A.B=C", help=SET)] = None,
    use: Use = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Worker processes (default: one per core).")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Run on a Dask cluster, such as tcp://10.0.0.1:8786.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Directory (default sweeps/<scenario>-<hash>).")] = None,
    form: Annotated[Format, typer.Option("--format", help="Format of the table of runs.")] = Format.CSV,
    plot: Annotated[bool, typer.Option("--plot", help="Also draw sweep.png and sweep.svg.")] = False,
) -> int:
    """Run a scenario with many seeds and settings, and compare them; a repeated command skips finished runs.

    A scenario file with schemes, such as `challenge`, has its schemes as the first axis.
    """
    if scheduler is not None and jobs is not None:
        raise ScenarioError("--jobs", "sets processes on this machine, which --scheduler does not use")
    planned = design.plan(builtin.resolve(scenario), axis or [], seeds, set_ or [])
    table.require(form)
    if plot:
        figures.require()
    for line in dict.fromkeys(line for cell in planned.cells for line in remarks.of(cell.scenario)):
        process.warn("fes", line)
    directory = out or ledger.default_directory(planned)
    with process.interruptible(), contextlib.ExitStack() as stack:
        workers = stack.enter_context(_workers(scheduler, jobs))
        finished = stack.enter_context(ledger.opened(directory, planned))
        try:
            _carry_out(planned, finished, workers)
        except Stopped as stopped:
            finished.read_again()
            done = sum(run.key in finished.done for run in planned.runs)
            raise Stopped(
                f"{stopped}: {done} of {len(planned.runs)} runs are done; the same command resumes the sweep"
            ) from None
    return _report(planned, finished, directory, form, plot)


@contextlib.contextmanager
def _workers(scheduler: str | None, jobs: int | None) -> Iterator[Workers]:
    opened = local.hired(jobs or local.cores()) if scheduler is None else cluster.connected(scheduler)
    with opened as workers:
        yield workers


def _carry_out(planned: Design, finished: Ledger, workers: Workers) -> None:
    """Carry out all runs that are not in the ledger."""
    with progress.shown(planned.name, sum(run.scenario.ticks for run in planned.runs)) as bar:

        def watch(ticks: int, runs: int) -> None:
            bar(ticks)
            bar.note(f"{runs}/{len(planned.runs)} runs")

        work.finish(planned, finished.done, finished.add, workers, watch)


def _report(planned: Design, finished: Ledger, directory: Path, form: Format, plot: bool) -> int:
    """Write tables and figure, and print the comparison."""
    results = Results.of(planned, finished.done)
    schemes = outcomes.of(planned, results.rows)
    try:
        written = results.write(directory, form)
        if schemes is not None:
            written.append(table.write_page(directory, "schemes.md", scheme_report.markdown(schemes)))
        if plot and (schemes is not None or picture.drawable(planned, results.rows)):
            with progress.shown("figure"):
                figure = scheme_picture.schemes_figure(schemes) if schemes else _figure(results)
                written += figures.save(figure, directory / "sweep")
    except OSError as error:
        raise FesError(f"cannot write the tables: {reason(error)}") from None
    shown = scheme_report.render(schemes) if schemes else report.render(planned, results.spreads, results.differences)
    printing.show(printing.console(), shown)
    for path in written:
        printing.line(path)
    failed = [(run, finished.done[run.key].error) for run in planned.runs if finished.done[run.key].error is not None]
    if failed:
        run, error_text = failed[0]
        first_failure = f"{planned.title(run.cell)}, seed {run.seed}: {error_text}"
        repeat = f"to repeat them, delete the lines with an error in {directory / ledger.LINES}"
        raise FesError(f"{len(failed)} of {len(planned.runs)} runs failed; the first is {first_failure}; {repeat}")
    return process.SUCCESS


def _figure(results: Results) -> "Figure":
    return picture.sweep_figure(results.design, results.rows, results.differences)
