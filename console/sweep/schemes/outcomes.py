"""The outcomes of schemes: a mean over the seeds for each, with its confidence interval."""

import difflib
from typing import NamedTuple

import numpy as np

from console.sweep import comparison
from console.sweep.design import Design
from console.sweep.table import Row
from fes.errors import ScenarioError
from world.config.scenario import knows_channel
from world.config.schemes import SCHEME, ColumnConfig

METRICS = "metrics."
"""Prefix of the outcomes in the columns of a file that states none."""


class Mean(NamedTuple):
    """The mean of an outcome over the seeds of a scheme."""

    mean: float
    """NaN if no run has a value."""
    low: float
    high: float
    """Bounds of the mean's confidence interval; NaN for less than two values."""
    reached: int
    """Number of runs with a value."""
    runs: int


class SchemeOutcomes(NamedTuple):
    """One scheme: a row of the table."""

    name: str
    is_told: bool
    """True if a law of its robots is told the channel."""
    means: tuple[Mean, ...]
    """One per column."""


def is_of_schemes(design: Design) -> bool:
    """True if a sweep compares schemes."""
    return SCHEME in design.axes


def columns(design: Design, rows: list[Row]) -> tuple[ColumnConfig, ...]:
    """The columns of the table; raises ScenarioError for one whose number no run has."""
    known = comparison.outcomes(design, rows)
    for column in design.columns:
        if column.of not in known:
            near = difflib.get_close_matches(column.of, known, 1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            raise ScenarioError(design.name, f"column.of: the summary has no number '{column.of}'{hint}")
    given = [ColumnConfig(of=name, title=name[len(METRICS) :]) for name in known if name.startswith(METRICS)]
    return design.columns or tuple(given)


def rows(design: Design, table: list[Row], shown: tuple[ColumnConfig, ...]) -> list[SchemeOutcomes]:
    """The rows, in the order of the cells."""
    by_column = [column.factor * comparison.values(design, table, column.of) for column in shown]
    return [
        SchemeOutcomes(
            design.title(index), knows_channel(cell.scenario), tuple(_mean(values[index]) for values in by_column)
        )
        for index, cell in enumerate(design.cells)
    ]


def _mean(values: comparison.Floats) -> Mean:
    finite = values[np.isfinite(values)]
    return Mean(*comparison.interval(finite), len(finite), len(values))
