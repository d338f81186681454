"""The command fes replay: show a recorded run, or execute it again and compare."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from console.connect.options import VERBOSE, Use
from console.dashboard import summary
from console.replay import browser, player, recorded, reexecution, robot_logs
from console.replay import log as logs
from console.replay.log import Log
from console.replay.robots import ReplayedRobots
from console.terminal import counting, printing, progress
from console.terminal.counting import Watch
from console.web.command import PORT, Port, Web
from fes import process
from fes.errors import FesError
from fes.recording.layout import AT_ITS_END
from fes.system import strict_json
from world.config.outside import extensions
from world.metrics.collector import MetricsCollector


def replay(
    target: Annotated[Path, typer.Argument(metavar="LOG", help="The log of a run or of a robot, or their folder.")],
    robot: Annotated[
        int | None, typer.Option(min=0, metavar="I", help="Execute this robot again, and compare it with the log.")
    ] = None,
    all_: Annotated[bool, typer.Option("--all", help="Execute the world and all robots again, and compare.")] = False,
    use: Use = None,
    speed: Annotated[float, typer.Option(min=1e-3, max=1e6, help="Simulated seconds per second.")] = 1.0,
    headless: Annotated[bool, typer.Option("--headless", help="No dashboard.")] = False,
    json_: Annotated[bool, typer.Option("--json", help="Print only the summary, as JSON.")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", help=VERBOSE)] = False,
    web: Web = False,
    port: Port = None,
) -> int:
    """Show a recorded run, or execute it again and compare it with the log, to the bit."""
    if robot is not None and all_:
        raise FesError(f"--all executes every robot again: give either --all or --robot {robot}")
    if web and (robot is not None or all_ or headless or json_):
        raise FesError("--web shows a run: give it without --robot, --all, --headless and --json")
    if port is not None and not web:
        raise FesError("--port is that of --web")
    if web:
        robot_logs.refuse(target)
    elif of_robots := robot_logs.chosen(target, robot, all_):
        return robot_logs.replay(of_robots, robot, json_)
    log = logs.load(target)
    extensions.check(log.scenario, log.extensions, str(log.path))
    if web:
        browser.show(log, PORT if port is None else port, speed)
    screen = printing.console(stderr=json_)
    if robot is not None:
        with progress.shown(f"robot {robot}", logs.length(log)) as watch:
            ticks = rerun_robot(log, robot, watch)
        _print(json_, {"robot": robot, "ticks": ticks}, f"robot {robot}, executed again", ticks)
    elif all_ or json_ or headless or not (printing.is_screen(screen) and _has_keyboard()):
        title = f"the world{' and all robots' if all_ else ''}, executed again"
        with progress.shown("world and robots" if all_ else "world", logs.length(log)) as watch:
            result = rerun(log, all_, watch)
        if not json_:
            printing.show(screen, summary.render(result, verbose))
            printing.show(screen, summary.last_line(result))
        _print(json_, result, title, result["ticks"])
    else:
        if (note := recorded.other_digits(log)) is not None:
            process.warn("fes", note)
        player.play(log, screen, speed)
    if log.ended not in (None, AT_ITS_END):
        write = process.tell if json_ else printing.line
        write(f"the run ended early: {log.ended}")
    complaint = log.complaint
    if complaint is not None:
        raise FesError(complaint)
    return process.SUCCESS


def rerun_robot(log: Log, robot: int, watch: Watch = counting.ignore) -> int:
    """Execute one robot again, from its recorded inputs; returns the number of ticks.

    `watch` is called with the completed ticks. Raises Mismatch where a Beacon or Command differs, and FesError if
    the run has no such robot or the log is incomplete.
    """
    robots = log.scenario.robots.number
    if robot >= robots:
        raise FesError(f"--robot {robot}: the run has robots 0 to {robots - 1}")
    own, ticks = ReplayedRobots(log, [robot]), 0
    for tick in log.ticks():
        own.step(tick)
        ticks += 1
        watch(ticks)
    return ticks


def rerun(log: Log, all_robots: bool = False, watch: Watch = counting.ignore) -> dict[str, Any]:
    """Execute the world again, and with `all_robots` all robots; returns the summary.

    `watch` is called with the completed ticks. Raises Mismatch where a message, a Report or the summary differs, and
    FesError where the log is incomplete.
    """
    robots = ReplayedRobots(log, range(log.scenario.robots.number)) if all_robots else None
    elapsed, latest = 0.0, MetricsCollector(log.scenario)
    for ticks, (moment, metrics) in enumerate(reexecution.accounted(log), 1):
        if robots is not None:
            robots.step(moment.recorded)
        latest = metrics
        if moment.recorded.report is not None:
            elapsed = moment.recorded.report.elapsed
        watch(ticks)
    return reexecution.summary(log, latest, elapsed)


def _has_keyboard() -> bool:
    """True if standard input is open and a terminal."""
    return sys.stdin is not None and sys.stdin.isatty()


def _print(json_: bool, result: dict[str, Any], title: str, ticks: int) -> None:
    printing.line(strict_json.dumps(result) if json_ else f"{title}: {ticks} ticks, the same to the bit")
