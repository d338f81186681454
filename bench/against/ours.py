"""Programs of this tree on one core: `python -m bench.against.ours PROGRAM ARGUMENT...` prints a number.

All rates are per second of processor time, which other programs of the machine disturb least.
"""

import sys
import tempfile
import time
from itertools import islice
from pathlib import Path

from console.backends import inprocess, stacked
from fes.recording.layout import NAME
from world.config.scenario import Scenario, load
from world.execution.recorder import Recorder

PAPER, HUNDRED = Path("configs/paper.toml"), Path("configs/hundred.toml")
SPACING = 78.0
"""Spacing of a large team [m]: it contracts. Its robots move, at 2.3 m/s or more in the mean of the first 10 s."""
SKIP = 4
"""Ticks until the links exist."""


def rate(scenario: Scenario, ticks: int, skip: int) -> float:
    """Ticks per second in process, over `ticks` ticks after `skip`."""
    every = inprocess.ticks(scenario)
    for _ in islice(every, skip):
        pass
    begun = time.process_time()
    done = sum(1 for _ in islice(every, ticks))
    return done / (time.process_time() - begun)


def paper(ticks: str, skip: str) -> float:
    """Ticks per second of the paper's ten robots."""
    return rate(load(PAPER), int(ticks), int(skip))


def team(robots: str, ticks: str, repeats: str) -> float:
    """Robot-ticks per second of a team that contracts, over the first ticks of several runs of other seeds."""
    costs = []
    for seed in range(int(repeats)):
        fields = {"robots.count": int(robots), "robots.spacing": SPACING, "run.seed": seed + 1}
        costs.append(1.0 / rate(load(HUNDRED, fields), int(ticks), SKIP))
    return int(robots) * len(costs) / sum(costs)


def stack(runs: str, seconds: str) -> float:
    """Robot-ticks per second of runs of the paper's ten robots as one array program, summaries included."""
    scenarios = [load(PAPER, {"run.seed": seed, "run.duration": float(seconds)}) for seed in range(int(runs))]
    begun = time.process_time()
    stacked.run(scenarios, "stack")
    ticks = sum(scenario.ticks * scenario.robots.number for scenario in scenarios)
    return ticks / (time.process_time() - begun)


def summary(seconds: str, recorded: str) -> float:
    """Ticks per second of a whole run of the paper's ten robots in process, with a log if `recorded` is "log"."""
    scenario = load(PAPER, {"run.duration": float(seconds)})
    inprocess.run(load(PAPER, {"run.duration": 1.0}), "warm")
    with tempfile.TemporaryDirectory() as folder:
        begun = time.process_time()
        if recorded == "log":
            with Recorder(Path(folder) / NAME, scenario, PAPER.stem, "inprocess") as recorder:
                inprocess.run(scenario, PAPER.stem, recorder=recorder)
        else:
            inprocess.run(scenario, PAPER.stem)
        return scenario.ticks / (time.process_time() - begun)


PROGRAMS = {program.__name__: program for program in (paper, team, stack, summary)}

if __name__ == "__main__":
    print(PROGRAMS[sys.argv[1]](*sys.argv[2:]))
