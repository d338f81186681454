"""Bias without a world, beside that of the lockstep world: `python -m tests.support.unsynchronized_bias --seeds 24`.

Per seed: mean error of all estimates from 60 to 120 s [m], of robots at clocks of their own, and of the product in
one loop. Then the means over the seeds with their standard errors.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from tests.support import loop
from tests.support.unsynchronized import OPTIMUM, Team

SETTLED, DURATION = 60.0, 120.0
"""Time from which errors count, and time of the end [s]."""


def biases(seed: int) -> tuple[float, float]:
    """Bias without a world and in the lockstep world [m]."""
    world = loop.load("measured.toml", run__seed=seed)
    team, dt = Team(world, seed), world.run.dt
    team.run(DURATION)
    ticks = loop.run(world, round(DURATION / dt)).estimates[round(SETTLED / dt) :]
    return team.bias(SETTLED), float(np.mean([np.mean(list(ends.values())) for ends in ticks])) - OPTIMUM


def main() -> None:
    """Print one line per seed, and the means."""
    parser = argparse.ArgumentParser(prog="python -m tests.support.unsynchronized_bias", description=__doc__)
    parser.add_argument("--seeds", type=int, default=24)
    seeds = range(1, parser.parse_args().seeds + 1)
    rows = []
    with ProcessPoolExecutor() as pool:
        for seed, row in zip(seeds, pool.map(biases, seeds), strict=True):
            rows.append((*row, row[0] - row[1]))
            print(seed, *(f"{value:+.3f}" for value in rows[-1]), flush=True)
    columns = np.array(rows).T
    for name, column in zip(("without a world", "lockstep world", "difference"), columns, strict=True):
        print(f"{name}: {column.mean():+.3f} +- {column.std(ddof=1) / np.sqrt(len(column)):.3f} m")


if __name__ == "__main__":
    main()
