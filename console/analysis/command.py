"""The commands that show evidence: fes plot and fes claims."""

from collections.abc import Callable, Mapping
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
from console.terminal import counting, printing, progress
from fes import process
from fes.errors import FesError, reason
from fes.recording import reader
from fes.system import fingerprint, strict_json
from world.config import builtin
from world.config.scenario import Scenario, load
from world.metrics.summary import ROBOTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER, MEASURED, TEAM = "paper", "measured", "team"

AGAIN = "executing the run again"

Drawings = Mapping[str, Callable[[], "Figure"]]
"""Name of a figure -> a function that draws it."""

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
    directory = out or Path("figures")
    if animate is not None:
        return _animate(target, animate, out)
    if target == PAPER:
        drawings = _of_paper()
    elif target == MEASURED:
        drawings = _of_measured()
    elif target == TEAM:
        drawings = _of_ends()
    else:
        source = Path(target)
        if not source.exists():
            raise FesError(f"no run directory or log {target}; figures without one: {PAPER}, {MEASURED}, {TEAM}")
        directory, drawings = out or (source.parent if source.is_file() else source), _of_run(source)
    for path in _drawn(drawings, directory):
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
    with progress.shown("computing", len(wanted), "claims") as bar:
        for number, key in enumerate(wanted):
            bar(number)
            bar.note(key)
            results[key] = claims.CLAIMS[key]()
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
    seen = _history(Path(target))
    with progress.shown("drawing", len(animation.playback(seen, path).ticks), "frames") as watch:
        animation.write(seen, path, watch)
    printing.line(path)
    return process.SUCCESS


def _drawn(drawings: Drawings, directory: Path) -> list[Path]:
    """The files of these figures, drawn one after the other; raises FesError if they cannot be written."""
    written: list[Path] = []
    with progress.shown("drawing", len(drawings), "figures") as bar:
        try:
            directory.mkdir(parents=True, exist_ok=True)
            for number, (name, draw) in enumerate(drawings.items()):
                bar(number)
                bar.note(name)
                written += figures.save(draw(), directory / name)
        except OSError as error:
            raise FesError(f"cannot write figures: {reason(error)}") from None
    return written


def _of_paper() -> Drawings:
    seen = _followed("the paper's run", load(builtin.file_of("paper")))
    neighborhood = load(builtin.file_of("neighborhood"))
    steps = step_study.seeking_steps(), step_study.tick_steps()
    with progress.shown("other steps", sum(steps), "steps") as watch:
        seeking, closed = counting.parts(watch, *steps)
        errors = step_study.seeking_errors(seeking), step_study.tick_errors(neighborhood, watch=closed)
    return {
        "fig1-outage": figures.outage_figure,
        "fig3-index": figures.index_figure,
        "fig5-formation": lambda: figures.formation_figure(seen),
        "fig6-convergence": lambda: figures.convergence_figure(seen),
        "steps": lambda: figures.step_figure(*errors),
    }


def _of_measured() -> Drawings:
    runs = convergence_study.study(builtin.FOLDER)
    with progress.shown("many seeds", runs.ticks) as watch:
        learning = convergence_study.learn(runs, watch)
    return {"measured": lambda: figures.learning_figure(learning)}


def _of_ends() -> Drawings:
    """The figure of the runs of ENDS, with their team index."""
    overrides = {"objective.team_index": True}
    runs = {title: _followed(name, load(builtin.file_of(name), overrides)) for title, name in ENDS.items()}
    return {"team": lambda: team_figures.ends_figure(runs)}


def _of_run(target: Path) -> Drawings:
    """The figures of a run."""
    seen = _history(target)
    team = {"team": lambda: team_figures.team_figure(seen)} if seen.team.size else {}
    return {
        "formation": lambda: figures.formation_figure(seen),
        "convergence": lambda: figures.convergence_figure(seen),
        **team,
    }


def _followed(title: str, scenario: Scenario, name: str = "") -> History:
    """The history of a scenario, which runs in this process."""
    with progress.shown(title, scenario.ticks) as watch:
        return history.follow(scenario, name, watch)


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
    with progress.shown(AGAIN, logs.length(log)) as watch:
        return history.recorded(log, watch)


def _executed_again(directory: Path) -> History:
    """The history of a run executed again from its scenario; raises FesError if its digest differs."""
    scenario = directory / "scenario.toml"
    if not scenario.is_file() or not (directory / "summary.json").is_file():
        raise FesError(f"{directory} is not a run directory: it lacks scenario.toml or summary.json")
    summary, loaded = processes.read_summary(directory), load(scenario)
    if summary.get("clock") == ROBOTS:
        advice = f"`fes replay {directory} --all` checks it"
        raise FesError(f"{directory} is a run of real robots, without figures: {advice}")
    ticks = summary.get("ticks")
    if not isinstance(ticks, int) or not 1 <= ticks <= loaded.ticks or "digest" not in summary:
        raise FesError(f"{directory / 'summary.json'} is not a summary of {scenario.name}: it lacks ticks or digest")
    run = loaded.run.model_copy(update={"duration": ticks * loaded.run.dt})
    name = summary.get("scenario")
    again = loaded.model_copy(update={"run": run})
    run_history = _followed(AGAIN, again, name if isinstance(name, str) else "")
    if run_history.digest != summary["digest"]:
        current = f"this is {recorded.own_origin()}"
        try:
            origin = f"it was made with {fingerprint.text(summary['arithmetic'])}"
        except (KeyError, TypeError, ValueError):
            origin = "its summary does not name the arithmetic"
        raise FesError(f"{directory} cannot be executed again bit for bit here: {origin}; {current}")
    return run_history
