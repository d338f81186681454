"""The command fes replay: a recorded run again, to look at, to sum up, or to execute and compare."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from console.connect.options import VERBOSE
from console.dashboard import summary
from console.replay import log as logs
from console.replay import player, reexecution
from console.replay.log import Log
from console.replay.reexecution import ReplayedRobots
from console.terminal import printing, progress
from fes import process
from fes.errors import FesError
from fes.recording.layout import AT_ITS_END
from fes.system import strict_json
from world.metrics.collector import MetricsCollector


def replay(
    target: Annotated[Path, typer.Argument(metavar="LOG", help="A log, run.mcap, or a run directory.")],
    robot: Annotated[
        int | None, typer.Option(min=0, metavar="I", help="Execute this robot's code again, and compare.")
    ] = None,
    all_: Annotated[
        bool, typer.Option("--all", help="Execute world and robots again, and compare everything.")
    ] = False,
    speed: Annotated[float, typer.Option(min=1e-3, max=1e6, help="Simulated seconds a second.")] = 1.0,
    headless: Annotated[bool, typer.Option("--headless", help="No dashboard.")] = False,
    json_: Annotated[bool, typer.Option("--json", help="Print the summary as JSON, and nothing else.")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", help=VERBOSE)] = False,
) -> int:
    """Show a recorded run again; or execute it again, bit for bit."""
    if robot is not None and all_:
        raise FesError(f"--all executes every robot again, give it or --robot {robot}")
    log = logs.load(target)
    screen = printing.console(stderr=json_)
    if robot is not None:
        with progress.bar(f"robot {robot}, executed again", _length(log)) as bar:
            ticks = alone(log, robot, bar.advance)
        _print(json_, {"robot": robot, "ticks": ticks}, f"robot {robot}, executed again", ticks)
    elif all_ or json_ or headless or not (printing.is_screen(screen) and _has_keyboard()):
        what = f"the world{' and all robots' if all_ else ''}, executed again"
        with progress.bar(what, _length(log)) as bar:
            result = again(log, all_, bar.advance)
        if not json_:
            printing.show(screen, summary.render(result, verbose))
        _print(json_, result, what, result["ticks"])
    else:
        player.play(log, screen, speed)
    if log.ended not in (None, AT_ITS_END):
        say = process.tell if json_ else printing.line
        say(f"the run ended early: {log.ended}")
    complaint = log.complaint
    if complaint is not None:
        raise FesError(complaint)
    return process.SUCCESS


def alone(log: Log, robot: int, told: Callable[[], None] = lambda: None) -> int:
    """Execute one robot again, from its recorded inputs; returns the number of ticks, or raises Mismatch.

    `told` is called after each tick.
    """
    robots = log.scenario.robots.number
    if robot >= robots:
        raise FesError(f"--robot {robot}: the run has robots 0 to {robots - 1}")
    own, ticks = ReplayedRobots(log, [robot]), 0
    for tick in log.ticks():
        own.step(tick)
        ticks += 1
        told()
    return ticks


def again(log: Log, everybody: bool = False, told: Callable[[], None] = lambda: None) -> dict[str, Any]:
    """Execute the world again, and with `everybody` all robots; returns the summary.

    `told` is called after each tick.

    Raises Mismatch where a message comes out otherwise, and FesError where a Report or the summary does.
    """
    robots = ReplayedRobots(log, range(log.scenario.robots.number)) if everybody else None
    elapsed, found = 0.0, MetricsCollector(log.scenario)
    for moment, metrics in reexecution.accounted(log):
        if robots is not None:
            robots.step(moment.recorded)
        found = metrics
        if moment.recorded.report is not None:
            elapsed = moment.recorded.report.elapsed
        told()
    return reexecution.summary(log, found, elapsed)


def _has_keyboard() -> bool:
    """True if standard input is a terminal; it may also be closed."""
    return sys.stdin is not None and sys.stdin.isatty()


def _length(log: Log) -> float:
    """Ticks that a log has, or may have if it has no end."""
    ticks = (log.summary or {}).get("ticks")
    return ticks if isinstance(ticks, int) else log.scenario.ticks


def _print(json_: bool, result: dict[str, Any], what: str, ticks: int) -> None:
    printing.line(strict_json.dumps(result) if json_ else f"{what}: {ticks} ticks, the same to the bit")
