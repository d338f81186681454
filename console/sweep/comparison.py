"""Statistics of the rows: those of each cell, and paired differences between cells on the same seeds.

A run that never reaches a level has no time to that level. Such runs are counted, not given a number. The mean of a
cell is over the runs with a value, a difference over the seeds at which both cells have one.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from console.sweep.design import Design
from console.sweep.table import ERROR, SEED, Row
from fes.arrays.types import Floats

CONFIDENCE = 0.95
"""Confidence level of the intervals of paired differences [1]."""

SETTINGS = frozenset({"robots", "ticks", "dt", "simulated_s", "optimal_separation"})
"""Numbers of the summary that the scenario determines."""


METRICS = "metrics."
"""Prefix of the outcomes that the metrics of the scenario compute; their units are not known."""


@dataclass(frozen=True)
class Spread:
    """An outcome over the runs of one cell."""

    cell: int
    outcome: str
    runs: int
    reached: int
    """Number of runs with a value."""
    mean: float
    median: float
    largest: float


@dataclass(frozen=True)
class PairedDifference:
    """An outcome in one cell minus the same outcome in another, at the same seeds."""

    axis: int
    base: int
    """The cell at the axis's first value."""
    compared: int
    outcome: str
    pairs: int
    """Number of seeds at which both cells have a value."""
    only_base: int
    only_other: int
    """Numbers of seeds at which only that cell has a value."""
    mean: float
    low: float
    high: float
    """Bounds of the mean's confidence interval, NaN for fewer than two pairs."""


def outcomes(design: Design, rows: list[Row]) -> list[str]:
    """The columns of numbers that are results of a run."""
    given = {*design.axes, SEED, ERROR, *SETTINGS}
    columns = [name for name in (rows[0] if rows else {}) if name not in given]
    return [name for name in columns if not any(isinstance(row[name], str) for row in rows)]


def values(design: Design, rows: list[Row], outcome: str) -> Floats:
    """An outcome by cell and seed [cells, seeds]; NaN where a run has no value."""
    numbers: list[Any] = [math.nan if row[outcome] is None else row[outcome] for row in rows]
    array = np.array(numbers, dtype=np.float64).reshape(len(design.cells), len(design.seeds))
    return np.where(np.isfinite(array), array, np.nan)


def spreads(design: Design, rows: list[Row]) -> Iterator[Spread]:
    """Every outcome in every cell."""
    for outcome in outcomes(design, rows):
        for cell, numbers in enumerate(values(design, rows, outcome)):
            finite = numbers[np.isfinite(numbers)]
            reached = len(finite) > 0
            mean, median, largest = (
                (float(finite.mean()), float(np.median(finite)), float(finite.max())) if reached else (math.nan,) * 3
            )
            yield Spread(cell, outcome, len(numbers), len(finite), mean, median, largest)


def differences(design: Design, rows: list[Row]) -> Iterator[PairedDifference]:
    """Every outcome, for each axis at each further value against its first, with the other axes fixed."""
    columns = {outcome: values(design, rows, outcome) for outcome in outcomes(design, rows)}
    for axis, base, compared in _contrasts(design):
        for outcome, by_cell in columns.items():
            yield difference(axis, base, compared, outcome, by_cell[base], by_cell[compared])


def difference(axis: int, base: int, compared: int, outcome: str, before: Floats, after: Floats) -> PairedDifference:
    """The paired difference after - before [seeds]."""
    in_base, in_compared = np.isfinite(before), np.isfinite(after)
    paired = (after - before)[in_base & in_compared]
    mean, low, high = interval(paired)
    only_base, only_other = (
        int(np.count_nonzero(seeds)) for seeds in (in_base & ~in_compared, in_compared & ~in_base)
    )
    return PairedDifference(axis, base, compared, outcome, len(paired), only_base, only_other, mean, low, high)


def interval(sample: Floats) -> tuple[float, float, float]:
    """Mean of a sample with the bounds of its confidence interval, by Student's t.

    >>> interval(np.array([1.0, 3.0]))[0]
    2.0
    """
    n = len(sample)
    mean = float(sample.mean()) if n else math.nan
    if n < 2:
        return mean, math.nan, math.nan
    half = student_t(n - 1) * float(sample.std(ddof=1)) / math.sqrt(n)
    return mean, mean - half, mean + half


@cache
def student_t(freedom: int, confidence: float = CONFIDENCE) -> float:
    """Quantile t for which P(|T| < t) = `confidence`, for `freedom` degrees of freedom.

    By bisection of the finite series for integer degrees: Abramowitz & Stegun 26.7.3 and 26.7.4.
    """
    low, high = 0.0, 0.5 * math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _within(middle, freedom) < confidence else (low, middle)
    return math.sqrt(freedom) * math.tan(0.5 * (low + high))


def _within(angle: float, freedom: int) -> float:
    """P(|T| < sqrt(freedom) tan(angle))."""
    square = math.cos(angle) ** 2
    odd = freedom % 2
    term = math.cos(angle) if odd else 1.0
    total = term if freedom > 1 else 0.0
    for k in range(3 if odd else 2, freedom - 1, 2):
        term *= square * (k - 1) / k
        total += term
    total *= math.sin(angle)
    return (angle + total) * 2.0 / math.pi if odd else total


def _contrasts(design: Design) -> Iterator[tuple[int, int, int]]:
    """Pairs of cells to compare: (axis, base cell, compared cell)."""
    numbers = {cell.values: number for number, cell in enumerate(design.cells)}
    for axis in range(len(design.axes)):
        first = design.values(axis)[0]
        for number, cell in enumerate(design.cells):
            base = numbers[(*cell.values[:axis], first, *cell.values[axis + 1 :])]
            if base != number:
                yield axis, base, number
