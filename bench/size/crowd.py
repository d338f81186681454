"""Robots that all start within radio range of each other: python -m bench.size.crowd [ROBOTS ...] [--rule RULE].

Each number of robots runs three ticks in one loop, log and summary included, in a process of its own. A line gives
wall-clock time, peak resident memory, and memory per contact beside the estimate of `world.simulation.crowd`.
"""

import argparse
import multiprocessing
import resource
import tempfile
import time
from multiprocessing.connection import Connection
from pathlib import Path

from console.backends import inprocess
from fes.extension.kinds import RULE
from fes.recording.layout import NAME
from world.config.scenario import Scenario, load
from world.execution.recorder import Recorder
from world.metrics import summary
from world.simulation import crowd

SCENARIO = Path("configs/hundred.toml")
SIZES = (300, 1_000, 3_000)
TICKS = 3
SPACING = 1.0
"""Spacing of the grid [m]: 3,000 robots stand within 80 m."""


def dense(robots: int, rule: str, ticks: int = TICKS) -> Scenario:
    """A scenario with this many `robots` within one radio range."""
    fields = {"robots.count": robots, "robots.spacing": SPACING, "formation.rule": rule}
    scenario = load(SCENARIO, fields)
    run = scenario.run.model_copy(update={"duration": ticks * scenario.run.dt})
    return scenario.model_copy(update={"run": run})


def measure(robots: int, rule: str, answer: Connection) -> None:
    """Run the scenario, and send contacts, time [s] and increase of resident memory [bytes] through `answer`."""
    before, begun = _peak(), time.perf_counter()
    scenario = dense(robots, rule)
    with tempfile.TemporaryDirectory() as folder:
        with Recorder(Path(folder) / NAME, scenario, "crowd", "inprocess") as recorder:
            reached = inprocess.run(scenario, "crowd", keep=recorder.conclude, recorder=recorder)
        summary.write(Path(folder), reached)
    answer.send((len(reached["radio"]), time.perf_counter() - begun, _peak() - before))


def _peak() -> int:
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def main() -> None:
    """Measure and print each number of robots."""
    parser = argparse.ArgumentParser(prog="python -m bench.size.crowd")
    parser.add_argument("robots", nargs="*", type=int, default=list(SIZES))
    parser.add_argument("--rule", choices=sorted(RULE.built_in), default="relative_neighborhood")
    flags = parser.parse_args()
    for robots in flags.robots:
        context = multiprocessing.get_context("spawn")
        receiver, sender = context.Pipe(duplex=False)
        child = context.Process(target=measure, args=(robots, flags.rule, sender))
        child.start()
        sender.close()
        contacts, seconds, taken = receiver.recv()
        child.join()
        print(
            f"{robots:6,} robots, {flags.rule}: {contacts:11,} contacts, {seconds:6.1f} s, {taken / 1e6:7,.0f} MB, "
            f"{taken / contacts:6,.0f} bytes per contact (assumed: {crowd.PER_CONTACT:,})",
            flush=True,
        )


if __name__ == "__main__":
    main()
