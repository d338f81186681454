"""The command fes replay: a recorded run again, to look at, to sum up, or to execute and compare."""

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from console import log as logs
from console import player, reexecution, summary
from console.log import Log
from console.reexecution import Robots
from fes import process
from fes.errors import FesError
from world.account import Account
from world.recorder import AT_ITS_END


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
) -> int:
    """Show a recorded run again; or execute it again, bit for bit."""
    if robot is not None and all_:
        raise FesError(f"--all executes every robot again, give it or --robot {robot}")
    log = logs.load(target)
    screen = Console(stderr=json_)
    if robot is not None:
        ticks = alone(log, robot)
        _print(screen, json_, {"robot": robot, "ticks": ticks}, f"robot {robot}, executed again", ticks)
    elif all_ or json_ or headless or not (screen.is_terminal and sys.stdin.isatty()):
        result = again(log, everybody=all_)
        ticks = result["ticks"]
        if not json_:
            screen.print(summary.render(result))
        _print(screen, json_, result, f"the world{' and all robots' if all_ else ''}, executed again", ticks)
    else:
        player.play(log, screen, speed)
    if log.ended not in (None, AT_ITS_END):
        screen.print(f"the run ended early: {log.ended}", highlight=False, markup=False, soft_wrap=True)
    complaint = log.complaint
    if complaint is not None:
        raise FesError(complaint)
    return process.SUCCESS


def alone(log: Log, robot: int) -> int:
    """Execute one robot again, from its recorded inputs; returns the number of ticks, or raises Mismatch."""
    robots = log.scenario.robots.number
    if robot >= robots:
        raise FesError(f"--robot {robot}: the run has robots 0 to {robots - 1}")
    own, ticks = Robots(log, [robot]), 0
    for tick in log.ticks():
        own.step(tick)
        ticks += 1
    return ticks


def again(log: Log, everybody: bool = False) -> dict[str, Any]:
    """Execute the world again, and with `everybody` all robots; returns the summary.

    Raises Mismatch where a message comes out otherwise, and FesError where a Report or the summary does.
    """
    robots = Robots(log, range(log.scenario.robots.number)) if everybody else None
    elapsed, found = 0.0, Account(log.scenario)
    for moment, sums in reexecution.accounted(log):
        if robots is not None:
            robots.step(moment.recorded)
        found = sums
        if moment.recorded.report is not None:
            elapsed = moment.recorded.report.elapsed
    return reexecution.summary(log, found, elapsed)


def _print(screen: Console, json_: bool, result: dict[str, Any], what: str, ticks: int) -> None:
    if json_:
        print(json.dumps(result))
    else:
        screen.print(f"{what}: {ticks} ticks, the same to the bit", highlight=False)
