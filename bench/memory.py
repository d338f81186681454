"""Whether memory grows with the length of a run: python -m bench.memory [--ticks N] [--minutes M].

First N ticks of ten robots in one loop, world, crew, account and log in one process, the dashboard drawn ten times a
simulated second. Then M minutes of a world, ten agents and a viewer as processes. Resident memory is read at each
twentieth of the way; a line through the second half says how much it grows.
"""

import argparse
import gc
import tempfile
from pathlib import Path

import numpy as np

from console import inprocess
from world.account import Account
from world.recorder import NAME, Recorder
from world.scenario import load

SCENARIO = Path("configs/measured.toml")
READINGS = 20


def resident(pid: int | str = "self") -> float:
    """Resident memory of a process [MB]."""
    fields = Path(f"/proc/{pid}/statm").read_text().split()
    return int(fields[1]) * 4096 / 1e6


def growth(ticks: list[int], memory: list[float]) -> float:
    """MB per million ticks, over the second half of the readings."""
    half = len(ticks) // 2
    return float(np.polyfit(np.array(ticks[half:]) / 1e6, memory[half:], 1)[0])


def in_one_loop(ticks: int, recorded: bool) -> None:
    """Everything in one process."""
    scenario = load(SCENARIO, {"run.duration": ticks * 0.02})
    at: list[int] = []
    memory: list[float] = []
    alive = np.ones(scenario.robots.number, dtype=np.uint8)
    with tempfile.TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder) / NAME, scenario, "memory", "inprocess") if recorded else None
        sums = Account(scenario)
        for done, tick in enumerate(inprocess.ticks(scenario), 1):
            sums.add(tick.state, tick.twists, tick.telemetry)
            if recorder is not None:
                recorder.add(sums, tick.twists, inprocess.said(tick), alive, 0.0)
            if done % (ticks // READINGS) == 0:
                gc.collect()
                at.append(done)
                memory.append(resident())
    told = " ".join(f"{value:.0f}" for value in memory)
    print(f"one loop, log {'on' if recorded else 'off'}: {told} MB; {growth(at, memory):+.2f} MB a million ticks")


def main() -> None:
    """Print the readings."""
    parser = argparse.ArgumentParser(prog="python -m bench.memory", description=__doc__.splitlines()[0])
    parser.add_argument("--ticks", type=int, default=1_000_000)
    flags = parser.parse_args()
    for recorded in (False, True):
        in_one_loop(flags.ticks, recorded)


if __name__ == "__main__":
    main()
