"""Worst errors of the elementary functions against mpmath: python -m tests.support.accuracy [--points 1000000].

Prints a Markdown table with each function over each range: its worst error in units in the last place (ulp) and the
argument there, and the share of results that are not the nearest float. Beside it stands that of numpy's own
function. A million points take about 20 minutes on two cores. The exit code is 1 if an error exceeds its bound.
"""

import argparse
import multiprocessing
import sys
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from tests.support import ulps
from tests.support.accuracy_ranges import TRIALS, Trial

AT_ONCE = 50_000
"""Points of a range that a process compares at a time."""


class Errors(NamedTuple):
    """Errors at some points of a range."""

    worst: float
    """[ulp]"""
    where: tuple[float, ...]
    """Arguments of the worst error."""
    inexact: int
    """Number of results that are not the nearest float."""
    numpys: float
    """Worst error of numpy's function [ulp]."""


def compare(trial: Trial, points: int, seed: list[int]) -> Errors:
    """Errors of a trial at random points."""
    generator = np.random.default_rng(seed)
    arguments = [draw(generator, points) for draw in trial.arguments]
    truth = ulps.exact(trial.exact, *arguments)
    own = ulps.errors(trial.ours(*arguments), truth)
    worst = int(own.argmax())
    where = tuple(float(argument[worst]) for argument in arguments)
    numpys = ulps.errors(trial.numpys(*arguments), truth)
    return Errors(float(own[worst]), where, int(np.count_nonzero(own > 0.5)), float(numpys.max()))


def _part(points: int, task: tuple[int, int]) -> Errors:
    """Errors of a part of a trial, given by their indices."""
    trial, part = task
    return compare(TRIALS[trial], points, [trial, part])


def table(points: int, processes: int) -> Iterator[tuple[Trial, Errors]]:
    """Errors of each trial at `points` points, rounded up to whole parts."""
    at_once = min(AT_ONCE, points)
    parts = -(-points // at_once)
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        tasks = [(trial, part) for trial in range(len(TRIALS)) for part in range(parts)]
        results = pool.imap(partial(_part, at_once), tasks)
        for trial in TRIALS:
            errors = [next(results) for _ in range(parts)]
            worst = max(errors)
            inexact, numpys = sum(part.inexact for part in errors), max(part.numpys for part in errors)
            yield trial, Errors(worst.worst, worst.where, inexact, numpys)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="worst errors of the elementary functions against mpmath")
    parser.add_argument("--points", type=int, default=1_000_000, help="points of each range")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    print("| function | range | worst error [ulp] | at | not the nearest float | numpy's worst error [ulp] |")
    print("|---|---|---|---|---|---|")
    exceeded = []
    for trial, errors in table(options.points, options.processes):
        where = ", ".join(f"{value!r}" for value in errors.where)
        share = errors.inexact / (-(-options.points // min(AT_ONCE, options.points)) * min(AT_ONCE, options.points))
        row = f"{trial.function} | {trial.range} | {errors.worst:.3f} | {where} | {share:.1%} | {errors.numpys:.3f}"
        print(f"| {row} |", flush=True)
        if errors.worst >= trial.bound:
            exceeded.append(f"{trial.function}, {trial.range}: {errors.worst:.3f} ulp, allowed {trial.bound}")
    print(*exceeded, sep="\n", end="\n" if exceeded else "", file=sys.stderr)
    return 1 if exceeded else 0


if __name__ == "__main__":
    sys.exit(main())
