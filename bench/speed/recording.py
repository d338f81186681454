"""Cost of a log: its size, and rates with and without it, measured alternately, in one loop and in processes."""

import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bench.speed import lockstep
from console.backends import inprocess
from fes.recording.layout import NAME
from world.config.scenario import Scenario, load
from world.execution.recorder import Recorder
from world.metrics import report_builder

ROUNDS = 8
DURATION = 10.0
"""Simulated time per run in processes [s]."""

TICKS = 2000
"""Ticks per run in one loop."""

BUDGET = 0.9
IN_ONE_LOOP = 0.8
"""Budget of the ratio in one loop, without the time of the payloads, which a run without a log does not encode."""


class Cost(NamedTuple):
    """Wall-clock time of one recorded run in one loop; per tick [s], except for the end."""

    tick: float
    payloads: float
    """Encoding of the messages that would cross the bus."""
    add: float
    """`Recorder.add`, with the Report."""
    report: float
    """Building of the Report, of which a tenth of a second has one."""
    end: float
    """From the last tick to the closed log [s]."""


def size(scenario: Path) -> float:
    """Bytes per robot-tick of a log."""
    loaded = load(scenario)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / NAME
        with Recorder(path, loaded, scenario.stem, "inprocess") as recorder:
            inprocess.run(loaded, scenario.stem, recorder=recorder)
        return path.stat().st_size / (loaded.ticks * loaded.robots.number)


def bare(scenario: Scenario) -> float:
    """Wall-clock time per tick of a run in one loop without a log [s]."""
    begun = time.perf_counter()
    inprocess.run(scenario, "bench")
    return (time.perf_counter() - begun) / scenario.ticks


class _Clock:
    """Total wall-clock time of a function [s], which is measured while this replaces it."""

    def __init__(self, owner: object, name: str) -> None:
        self.total = 0.0
        self._owner, self._name, self._function = owner, name, getattr(owner, name)

    def __enter__(self) -> "_Clock":
        def timed(*words: object) -> object:
            begun = time.perf_counter()
            result = self._function(*words)
            self.total += time.perf_counter() - begun
            return result

        setattr(self._owner, self._name, timed)
        return self

    def __exit__(self, *error: object) -> None:
        setattr(self._owner, self._name, self._function)


def recorded(scenario: Scenario) -> Cost:
    """Cost of a run in one loop with a log."""
    with (
        tempfile.TemporaryDirectory() as folder,
        _Clock(Recorder, "add") as add,
        _Clock(inprocess, "packed") as payloads,
        _Clock(report_builder, "build") as report,
    ):
        with Recorder(Path(folder) / NAME, scenario, "bench", "inprocess") as recorder:
            begun = time.perf_counter()
            inprocess.run(scenario, "bench", recorder=recorder)
            ended = time.perf_counter()
        end = time.perf_counter() - ended
    tick, *parts = (seconds / scenario.ticks for seconds in (ended - begun, payloads.total, add.total, report.total))
    return Cost(tick, parts[0], parts[1], parts[2], end)


def in_one_loop(path: Path) -> None:
    """Print times and ratios, round by round."""
    loaded = load(path)
    scenario = load(path, {"run.duration": TICKS * loaded.run.dt})
    rows = []
    for number in range(ROUNDS):
        if number % 2:
            cost, without = recorded(scenario), bare(scenario)
        else:
            without, cost = bare(scenario), recorded(scenario)
        ratios = without / cost.tick, without / (cost.tick - cost.payloads)
        rows.append((*ratios, cost.add, cost.add - cost.report, cost.payloads, cost.report, cost.end, without))
        print(f"  with {1 / cost.tick:6.0f}    without {1 / without:6.0f} ticks/s", *(f"{x:5.2f}" for x in ratios))
    whole, cheap, *times = np.median(rows, axis=0)
    print(f"  median with/without {whole:.2f}, without the payloads' encoding {cheap:.2f} (budget >= {IN_ONE_LOOP})")
    names = ("Recorder.add", "without its Report", "payloads", "Report", "end of the log", "a tick without a log")
    print("  [us]", ", ".join(f"{name} {value * 1e6:.0f}" for name, value in zip(names, times, strict=True)))


def in_processes(scenario: Path) -> None:
    """Print rates and their ratio, round by round."""
    ratios = []
    for number in range(ROUNDS):
        flags = ["--record", "--no-record"]
        if number % 2:
            flags.reverse()  # the second run may meet a warmer machine
        rates = {flag: lockstep.fes(scenario, DURATION, flag) for flag in flags}
        ratios.append(rates["--record"] / rates["--no-record"])
        print(f"  with {rates['--record']:6.0f}    without {rates['--no-record']:6.0f} ticks/s    {ratios[-1]:.2f}")
    print(f"  median with/without {np.median(ratios):.2f} (budget >= {BUDGET})")


def main() -> None:
    """Print sizes and rates."""
    for scenario in (Path("configs/paper.toml"), Path("configs/measured.toml")):
        print(f"log of {scenario}: {size(scenario):.0f} bytes per robot-tick (budget 200)")
        print("in one loop:")
        in_one_loop(scenario)
        print("in processes:")
        in_processes(scenario)


if __name__ == "__main__":
    main()
