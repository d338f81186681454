"""The command fes sweep: from its arguments to its files."""

import contextlib
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from console.analysis import figures
from console.connect.options import SET, Scenario
from console.sweep import cluster, comparison, design, ledger, local, picture, report, table, work
from console.sweep.comparison import PairedDifference, Spread
from console.sweep.design import Design
from console.sweep.ledger import Ledger
from console.sweep.table import Format, Row
from console.sweep.work import Workers
from console.terminal import printing, progress
from fes import process
from fes.errors import FesError, ScenarioError, Stopped, reason
from world.config import builtin, remarks


def sweep(
    scenario: Scenario,
    seeds: Annotated[str, typer.Option(metavar="A:B", help="Seeds A to B - 1, or a list such as 1,2,5.")],
    axis: Annotated[
        list[str] | None, typer.Option(metavar="A.B=V,W", help="A field and its values; several axes are crossed.")
    ] = None,
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="A.B=C", help=SET)] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Worker processes (default: one a core).")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Run on a Dask cluster, such as tcp://10.0.0.1:8786.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Directory (default sweeps/<scenario>-<hash>).")] = None,
    form: Annotated[Format, typer.Option("--format", help="Of the table of runs.")] = Format.CSV,
    plot: Annotated[bool, typer.Option("--plot", help="Draw sweep.png and sweep.svg too.")] = False,
) -> int:
    """Run a scenario with many seeds and settings, and compare them; what is done is not done again."""
    if scheduler is not None and jobs is not None:
        raise ScenarioError("--jobs", "counts processes of this machine, and --scheduler runs on a cluster's")
    planned = design.plan(builtin.resolve(scenario), axis or [], seeds, set_ or [])
    table.require(form)
    if plot:
        figures.require()
    for line in dict.fromkeys(line for cell in planned.cells for line in remarks.of(cell.scenario)):
        process.warn("fes", line)
    directory = out or ledger.default_directory(planned)
    with process.interruptible(), contextlib.ExitStack() as stack:
        workers = stack.enter_context(_workers(scheduler, jobs))
        book = stack.enter_context(ledger.opened(directory, planned))
        try:
            _work_off(planned, book, workers)
        except Stopped as stopped:
            book.read_again()
            done = sum(run.key in book.done for run in planned.runs)
            raise Stopped(
                f"{stopped}: {done} of {len(planned.runs)} runs are done, and the same command does the rest"
            ) from None
    return _tell(planned, book, directory, form, plot)


@contextlib.contextmanager
def _workers(scheduler: str | None, jobs: int | None) -> Iterator[Workers]:
    hired = local.hired(jobs or local.cores()) if scheduler is None else cluster.connected(scheduler)
    with hired as workers:
        yield workers


def _work_off(planned: Design, book: Ledger, workers: Workers) -> None:
    """Carry out all runs that the ledger does not have."""
    with progress.bar(planned.name) as bar:
        missing = [run for run in planned.runs if run.key not in book.done]
        total, done = len(planned.runs), len(planned.runs) - len(missing)
        before = sum(run.scenario.ticks for run in planned.runs if run.key in book.done)
        bar.measure(sum(run.scenario.ticks for run in planned.runs))

        def watch(ticks: int) -> None:
            bar.reach(before + ticks)
            bar.note(f"{done}/{total} runs")

        watch(0)
        ended = workers.carry_out(work.batches(planned.name, missing, workers.count), watch)
        with contextlib.closing(ended):
            for some in ended:
                book.add(some)
                done += len(some)


def _tell(planned: Design, book: Ledger, directory: Path, form: Format, plot: bool) -> int:
    """Write the tables and the figure, and say what was found."""
    rows = table.rows(planned, book.done)
    spreads = list(comparison.spreads(planned, rows))
    differences = list(comparison.differences(planned, rows))
    try:
        written = [
            table.write(directory, "table", rows, form),
            table.write(directory, "cells", [_cell(planned, one) for one in spreads]),
        ]
        if differences:
            written.append(table.write(directory, "differences", [_contrast(planned, one) for one in differences]))
        if plot and picture.drawable(planned, rows):
            with progress.bar("figure"):
                written += figures.save(picture.sweep_figure(planned, rows, differences), directory / "sweep")
    except OSError as error:
        raise FesError(f"cannot write the tables: {reason(error)}") from None
    printing.show(printing.console(), report.render(planned, spreads, differences))
    for path in written:
        printing.line(path)
    failed = [(run, book.done[run.key].error) for run in planned.runs if book.done[run.key].error is not None]
    if failed:
        run, why = failed[0]
        told = f"{planned.title(run.cell)}, seed {run.seed}: {why}"
        repeat = f"to repeat them, delete the lines with an error in {directory / ledger.LINES}"
        raise FesError(f"{len(failed)} of {len(planned.runs)} runs failed, the first {told}; {repeat}")
    return process.SUCCESS


def _cell(planned: Design, one: Spread) -> Row:
    found = asdict(one)
    return dict(zip(planned.axes, planned.cells[found.pop("cell")].values, strict=True)) | found


def _contrast(planned: Design, one: PairedDifference) -> Row:
    """A row of differences.csv: along which axis, between which values, at which values of the other axes."""
    base, other = (dict(zip(planned.axes, planned.cells[cell].values, strict=True)) for cell in (one.base, one.other))
    axis = planned.axes[one.axis]
    found = asdict(one) | {"axis": axis, "base": base[axis], "other": other[axis]}
    return found | {f"at {held}": value if held != axis else None for held, value in base.items()}
