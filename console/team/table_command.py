"""fes team run: a team on a simulated table, with all processes of real robots."""

from pathlib import Path
from typing import Annotated, Any

import typer

from console.connect import index_source, options, run_directory
from console.dashboard import live
from console.team.table_run import TableRun
from console.terminal import printing, progress
from fes import process
from fes.system import strict_json
from world.config import builtin
from world.config.scenario import load, parse_override
from world.metrics.summary import write, write_scenario

BELOW = 7
"""Most lines after the last frame, without those of the gates."""

LOST, CONCEALED = 1.0, 0.03
"""Time for which bodies may stand still [s], and share of ticks that conceal a pause, in a run in real time."""

SHORTEST = 20.0
"""Shortest run whose concealed ticks are judged [s]: each link begins with about six of them."""


def run(
    scenario: options.Scenario,
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="A.B=C", help=options.SET)] = None,
    use: options.Use = None,
    body: Annotated[str | None, typer.Option(help="Override tabletop.body: kinematic or mujoco.")] = None,
    seed: Annotated[int | None, typer.Option(help="Override run.seed.")] = None,
    duration: Annotated[float | None, typer.Option(help="Override run.duration [s].")] = None,
    out: Annotated[Path | None, typer.Option(help="Run directory (default runs/<scenario>-<n>).")] = None,
    headless: Annotated[bool, typer.Option("--headless", help="Show no dashboard.")] = False,
    json_: Annotated[bool, typer.Option("--json", help="Print the summary as JSON, and nothing else.")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="After the dashboard, print every report of the gates.")
    ] = False,
) -> int:
    """Run a team on a simulated table, with a fes-robot and a gate for each robot."""
    fields = [("run.seed", seed), ("run.duration", duration), ("tabletop.body", body)]
    given = [*(set_ or []), *(f"{field}={value}" for field, value in fields if value is not None)]
    path = builtin.resolve(scenario)
    loaded = load(path, dict(parse_override(text) for text in given))
    screen = printing.console(stderr=json_)
    shows = printing.is_screen(screen) and not headless and not json_
    with run_directory.created(path.stem, out) as directory:
        write_scenario(directory.path, loaded)
        lines: list[str] = []
        say = lines.append if shows or json_ else printing.line
        team = TableRun(loaded, directory.path, say)
        if shows:
            with live.Screen(screen, BELOW, "the robots", index_source.of(loaded)) as frames:
                result = process.supervise(lambda: team.run(frames))
        else:
            with progress.drawn("running", loaded.ticks) as bar:
                result = process.supervise(lambda: team.run(None, bar))
        write(directory.path, result)
        if json_:
            print(strict_json.dumps(result), flush=True)
        else:
            for line in conclusion(result, lines, directory.path, verbose):
                printing.line(line)
    return process.SUCCESS


def was_busy(result: dict[str, Any]) -> bool:
    """True if the machine could not keep up with real time."""
    return bool(_delay(result))


def _delay(result: dict[str, Any]) -> str:
    """The line that says why a run is not in real time; empty if it is."""
    lost, beacons = result["bodies_lost_s"], result["beacons"]
    if lost > LOST:
        return f"the machine was too busy for real time: the bodies stood still for {lost:.1f} s"
    share = beacons["concealed"] / max(1, beacons["heard"])
    if share > CONCEALED and result["moved_s"] >= SHORTEST:
        return f"the machine was too busy for real time: {100 * share:.1f} % of the beacons came late"
    return ""


def conclusion(result: dict[str, Any], reports: list[str], directory: Path, verbose: bool = False) -> list[str]:
    """The lines after a run: the reports of the gates or their number, the result, and its headline last."""
    shown = reports if verbose or not reports else [f"gates: {len(reports)} reports, which --verbose shows"]
    return [*shown, *_lines(result), f"run directory: {directory}", _headline(result)]


def _headline(result: dict[str, Any]) -> str:
    """The result in one line."""
    error, optimal = _length(result["separation_error_max"]), _length(result["optimal_separation"])
    within = f" at the end within {error} of r* = {optimal}" if result["links"] else ""
    return f"{result['robots']} robots, {result['links'] or 'no'} links{within}"


def _lines(result: dict[str, Any]) -> list[str]:
    """The summary in words."""
    estimate = _reached(result["estimate_time"]), _length(result["mean_estimate_error"])
    separation = _reached(result["separation_time"]), _length(result["separation_error_rms"])
    return [
        f"optimum r*: {_length(result['optimal_separation'])}",
        f"mean estimate: {estimate[0]}; error at the end {estimate[1]}",
        f"separations of {result['links']} links: {separation[0]}; rms error {separation[1]}",
        *filter(None, [_delay(result)]),
    ]


def _reached(time: float | None) -> str:
    return "not within 1 m of r* at the end" if time is None else f"within 1 m of r* since {time:.2f} s"


def _length(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.2f} m"
