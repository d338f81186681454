"""The commands that show evidence: fes plot and fes claims."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table
from rich.text import Text

from console.analysis import animation, claims, convergence_study, figures, history, step_study, team_figures
from console.analysis.history import History
from console.backends import processes
from console.connect.options import Use
from console.replay import log as logs
from console.replay import recorded
from console.replay.log import Log
from console.terminal import printing, progress
from fes import process
from fes.errors import FesError, reason
from fes.recording import reader
from fes.system import fingerprint, strict_json
from world.config import builtin
from world.config.scenario import load

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER, MEASURED, TEAM = "paper", "measured", "team"

ENDS = {
    "two nearest": "paper",
    "relative neighborhood": "neighborhood",
    "marks and plans": "team-paper-start",
}
"""Title of an end -> the scenario of its run."""


def plot(
    target: Annotated[str, typer.Argument(help="`paper`, `measured`, `team`, a run directory or a log.")],
    out: Annotated[
        Path | None, typer.Option(help="Output directory (default: figures/, or the run directory).")
    ] = None,
    animate: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw a run as an animation instead, in a .gif or .mp4 file.")
    ] = None,
    use: Use = None,
) -> int:
    """Draw figures as PNG and SVG: the paper's Figs. 1, 3, 5 and 6, beacon counts, final configurations, or a run."""
    if animate is not None:
        return _animate(target, animate, out)
    with progress.bar("figures") as bar:
        if target == PAPER:
            directory, drawn = out or Path("figures"), _paper_figures(bar)
        elif target == MEASURED:
            bar.note("many seeds of robots that count beacons")
            learning = convergence_study.learn(builtin.FOLDER)
            directory, drawn = out or Path("figures"), {"measured": figures.learning_figure(learning)}
        elif target == TEAM:
            directory, drawn = out or Path("figures"), {"team": team_figures.ends_figure(_ends(bar))}
        else:
            bar.note("executing the run again")
            source = Path(target)
            directory, drawn = out or (source.parent if source.is_file() else source), _run_figures(source)
        written = []
        try:
            directory.mkdir(parents=True, exist_ok=True)
            for name, figure in drawn.items():
                bar.note(name)
                written += figures.save(figure, directory / name)
        except OSError as error:
            raise FesError(f"cannot write figures: {reason(error)}") from None
    for path in written:
        printing.line(path)
    return process.SUCCESS


def show_claims(
    name: Annotated[str | None, typer.Argument(help=f"One of {', '.join(claims.CLAIMS)} (default: all).")] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the numbers as JSON.")] = False,
) -> int:
    """Compute the errors in the paper's text, and the numbers of the team index."""
    if name is not None and name not in claims.CLAIMS:
        raise FesError(f"no claim '{name}'; the claims are {', '.join(claims.CLAIMS)}")
    wanted, results = [name] if name else list(claims.CLAIMS), {}
    with progress.bar("claims", len(wanted)) as bar:
        for key in wanted:
            bar.note(key)
            results[key] = claims.CLAIMS[key]()
            bar.advance()
    if json_:
        print(strict_json.dumps(results))
        return process.SUCCESS
    screen = printing.console()
    for key, numbers in results.items():
        table = Table.grid(padding=(0, 2))
        for label, value in numbers.items():
            table.add_row(printing.cell(f"  {label}"), f"{value:.6g}")
        title = Text.assemble((key, "bold"), f": {str(claims.CLAIMS[key].__doc__).splitlines()[0]}")
        screen.print(title, soft_wrap=True)
        screen.print(table, soft_wrap=True)
    return process.SUCCESS


def _animate(target: str, path: Path, out: Path | None) -> int:
    """Draw a run as an animation in the file `path`."""
    if target in (PAPER, MEASURED, TEAM) and not Path(target).exists():
        raise FesError(f"--animate draws a run directory or a log, got '{target}'")
    if out is not None:
        raise FesError(f"--animate names its own file: omit --out {out}")
    animation.check(path)
    with progress.bar("animation") as bar:
        bar.note("executing the run again")
        seen = _history(Path(target))
        bar.measure(len(animation.playback(seen, path).ticks))
        bar.note("frames")
        animation.write(seen, path, bar.reach)
    printing.line(path)
    return process.SUCCESS


def _paper_figures(bar: progress.Bar) -> "dict[str, Figure]":
    bar.note("the paper's run")
    seen = history.follow(load(builtin.file_of("paper")))
    bar.note("the same run with other steps")
    return {
        "fig1-outage": figures.outage_figure(),
        "fig3-index": figures.index_figure(),
        "fig5-formation": figures.formation_figure(seen),
        "fig6-convergence": figures.convergence_figure(seen),
        "steps": figures.step_figure(
            step_study.seeking_errors(), step_study.tick_errors(load(builtin.file_of("neighborhood")))
        ),
    }


def _ends(bar: progress.Bar) -> dict[str, History]:
    """The runs of ENDS, with their team index."""
    runs = {}
    for title, name in ENDS.items():
        bar.note(f"the run of {name}")
        runs[title] = history.follow(load(builtin.file_of(name), {"objective.team_index": True}))
    return runs


def _run_figures(target: Path) -> "dict[str, Figure]":
    """The figures of a run."""
    seen = _history(target)
    team = {"team": team_figures.team_figure(seen)} if seen.team.size else {}
    return {"formation": figures.formation_figure(seen), "convergence": figures.convergence_figure(seen), **team}


def _history(target: Path) -> History:
    """The history of a run from its log, or from its directory if there is no log."""
    path = reader.find(target) if target.exists() else None
    return _executed_again(target) if path is None else _recorded(logs.load(path))


def _recorded(log: Log) -> History:
    """The history of the run in a log."""
    complaint = log.complaint
    if complaint is not None:
        process.complain("fes", complaint)
    if (note := recorded.other_digits(log)) is not None:
        process.warn("fes", note)
    return history.recorded(log)


def _executed_again(directory: Path) -> History:
    """The history of a run executed again from its scenario; raises FesError if its digest differs."""
    scenario = directory / "scenario.toml"
    if not scenario.is_file() or not (directory / "summary.json").is_file():
        raise FesError(f"{directory} is not a run directory: it lacks scenario.toml or summary.json")
    summary, loaded = processes.read_summary(directory), load(scenario)
    ticks = summary.get("ticks")
    if not isinstance(ticks, int) or not 1 <= ticks <= loaded.ticks or "digest" not in summary:
        raise FesError(f"{directory / 'summary.json'} is not a summary of {scenario.name}: it lacks ticks or digest")
    run = loaded.run.model_copy(update={"duration": ticks * loaded.run.dt})
    name = summary.get("scenario")
    run_history = history.follow(loaded.model_copy(update={"run": run}), name if isinstance(name, str) else "")
    if run_history.digest != summary["digest"]:
        current = f"this is {recorded.own_origin()}"
        try:
            origin = f"it was made with {fingerprint.text(summary['arithmetic'])}"
        except (KeyError, TypeError, ValueError):
            origin = "its summary does not name the arithmetic"
        raise FesError(f"{directory} cannot be executed again bit for bit here: {origin}; {current}")
    return run_history
