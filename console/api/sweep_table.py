"""The tables of a sweep, whose columns are numpy arrays."""

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from console.api import columns
from console.api.columns import Column
from console.sweep.design import Value
from console.sweep.table import TEXTS, Row
from fes.errors import FesError
from fes.settings.validation import short

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class ResultTable:
    """Rows of results, which all have the same columns."""

    rows: list[Row]
    """Each row by column: text, numbers, and None for a missing value."""

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self):,} rows of {len(self.columns)} columns)"

    def __getitem__(self, column: str) -> Column:
        """A column [rows]: bool, int64 or float64 (NaN for a missing number), or objects for text.

        Raises FesError for a column that the table lacks.
        """
        if column not in self.columns:
            near = difflib.get_close_matches(str(column), self.columns, 1, 0.0)
            nearest = f"the nearest is '{near[0]}', and " if near else ""
            raise FesError(f"no column '{short(str(column))}': {nearest}`columns` lists all {len(self.columns)}")
        return columns.column([row[column] for row in self.rows], column in TEXTS)

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in order."""
        return list(self.rows[0]) if self.rows else []

    def numpy(self) -> dict[str, Column]:
        """All columns by name, each [rows]."""
        return {name: self[name] for name in self.columns}

    def frame(self) -> "DataFrame":
        """The table as a data frame of pandas; raises FesError if pandas is not installed."""
        return columns.frame(self.numpy())


@dataclass(frozen=True, eq=False, repr=False)
class SweepTable(ResultTable):
    """A ResultTable with one row per run: cell by cell in the order of the axes, and by seed within a cell.

    Its columns are the axes, `seed`, the numbers of the summary by dotted name, and `error`. Numbers of the wall
    clock are excluded. `error` is the error of a run that failed, or None.
    """

    axes: dict[str, Sequence[Value]] = field(default_factory=dict)
    """Values of each axis, in order."""
    seeds: list[int] = field(default_factory=list)
    """Seeds of every cell, in order."""
    cells: ResultTable = field(default_factory=lambda: ResultTable([]))
    """Number, mean, median and largest value of each outcome in each cell, as in `cells.csv`."""
    differences: ResultTable = field(default_factory=lambda: ResultTable([]))
    """Paired differences between cells at the same seeds, as in `differences.csv`."""

    def grid(self, column: str) -> Column:
        """A column as an array with one dimension per axis, and the seeds last."""
        return self[column].reshape([len(values) for values in self.axes.values()] + [len(self.seeds)])
