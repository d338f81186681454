"""The outcomes of schemes: a mean over the seeds for each, with its confidence interval."""

import difflib
from typing import NamedTuple

import numpy as np

from console.sweep import comparison
from console.sweep.comparison import METRICS
from console.sweep.design import Design
from console.sweep.table import Row
from fes.arrays.types import Floats
from fes.errors import ScenarioError
from world.config.outside.schemes import SCHEME, ColumnConfig
from world.config.scenario import knows_channel


class Mean(NamedTuple):
    """The mean of an outcome over the seeds of a scheme."""

    mean: float
    """NaN if no run has a value."""
    low: float
    high: float
    """Bounds of the mean's confidence interval; NaN for fewer than two values."""
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


class SchemeTable(NamedTuple):
    """The table of schemes."""

    columns: tuple[ColumnConfig, ...]
    rows: list[SchemeOutcomes]
    """One per cell, in the order of the design."""


def of(design: Design, rows: list[Row]) -> SchemeTable | None:
    """The table of a sweep's rows, if it compares schemes.

    Raises ScenarioError for a column whose number no run has.
    """
    columns = _columns(design, rows) if SCHEME in design.axes else ()
    if not columns:
        return None
    by_column = [column.factor * comparison.values(design, rows, column.of) for column in columns]
    outcomes = [
        SchemeOutcomes(
            design.title(index), knows_channel(cell.scenario), tuple(_mean(values[index]) for values in by_column)
        )
        for index, cell in enumerate(design.cells)
    ]
    return SchemeTable(columns, outcomes)


def _columns(design: Design, rows: list[Row]) -> tuple[ColumnConfig, ...]:
    """The columns that the file states, or all numbers of metrics."""
    known = comparison.outcomes(design, rows)
    for column in design.columns:
        if column.of not in known:
            near = difflib.get_close_matches(column.of, known, 1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            raise ScenarioError(design.name, f"column.of: the summary has no number '{column.of}'{hint}")
    given = [ColumnConfig(of=name, title=name[len(METRICS) :]) for name in known if name.startswith(METRICS)]
    return design.columns or tuple(given)


def _mean(values: Floats) -> Mean:
    finite = values[np.isfinite(values)]
    return Mean(*comparison.interval(finite), len(finite), len(values))
