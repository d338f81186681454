"""Cost of a log: its size, and rates of the lockstep with and without it, measured alternately."""

import tempfile
from pathlib import Path

import numpy as np

from bench.speed import lockstep
from console.backends import inprocess
from fes.recording.layout import NAME
from world.config.scenario import load
from world.execution.recorder import Recorder

ROUNDS = 8
DURATION = 10.0
"""Simulated time per run [s]."""

BUDGET = 0.9


def size(scenario: Path) -> float:
    """Bytes per robot-tick of a log."""
    loaded = load(scenario)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / NAME
        with Recorder(path, loaded, scenario.stem, "inprocess") as recorder:
            inprocess.run(loaded, scenario.stem, recorder=recorder)
        return path.stat().st_size / (loaded.ticks * loaded.robots.number)


def main() -> None:
    """Print rates and their ratio, round by round."""
    for scenario in (Path("configs/paper.toml"), Path("configs/measured.toml")):
        print(f"log of {scenario}: {size(scenario):.0f} bytes per robot-tick (budget 200)")
        ratios = []
        for number in range(ROUNDS):
            flags = ["--record", "--no-record"]
            if number % 2:
                flags.reverse()  # the second run may meet a warmer machine
            rates = {flag: lockstep.fes(scenario, DURATION, flag) for flag in flags}
            ratios.append(rates["--record"] / rates["--no-record"])
            print(
                f"  with {rates['--record']:6.0f}    without {rates['--no-record']:6.0f} ticks/s    {ratios[-1]:.2f}"
            )
        print(f"  median with/without {np.median(ratios):.2f} (budget >= {BUDGET})")


if __name__ == "__main__":
    main()
