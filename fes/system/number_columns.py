"""Columns of numbers in a comma-separated file with a line of names. An error names file, line and rule."""

import csv
import io
from array import array
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Floats
from fes.errors import FesError

_WORDS = {"true": 1.0, "false": 0.0}
_SHOWN = 40
"""Longest text of a file that an error shows [characters]."""


class Column(NamedTuple):
    """The name of a column, and the numbers that it may hold."""

    name: str
    low: float
    high: float
    is_whole: bool = False
    """True for whole numbers only."""

    @property
    def rule(self) -> str:
        """The numbers that it may hold, in words."""
        if self.is_whole and (self.low, self.high) == (0.0, 1.0):
            return "0 or 1"
        kind = "a whole number" if self.is_whole else "a number"
        return f"{kind} from {self.low:g} to {self.high:g}"


def read(where: str, content: bytes, wanted: Sequence[tuple[Column, ...]]) -> dict[str, Floats]:
    """The wanted columns [k], by name; of each tuple the first column that the file has.

    `true` and `false` are 1 and 0. Further columns are ignored. Raises FesError in one line, which names `where`.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FesError(f"{where} is not text in UTF-8") from None
    rows = csv.reader(io.StringIO(text), skipinitialspace=True)
    try:
        names = [name.strip() for name in next(rows, [])]
        columns = _chosen(where, names, wanted)
        positions = [position for position, _ in columns]
        values, lines = array("d"), array("q")
        for fields in rows:
            if not "".join(fields).strip():
                continue
            if len(fields) != len(names):
                rule = f"must have {len(names)} fields, got {len(fields)}"
                raise FesError(f"{where}, line {rows.line_num}: {rule}: '{','.join(fields)[:_SHOWN]}'")
            lines.append(rows.line_num)
            try:
                values.extend([float(fields[position]) for position in positions])
            except ValueError:
                values.extend(_number(where, rows.line_num, column, fields[position]) for position, column in columns)
    except csv.Error as error:
        raise FesError(f"{where}, line {rows.line_num}: {error}") from None
    if not lines:
        raise FesError(f"{where} has no row after its line of names")
    table = np.array(values).reshape(-1, len(columns)).T.copy()
    for (_, column), numbers in zip(columns, table, strict=True):
        _check(where, lines, column, numbers)
    return {column.name: numbers for (_, column), numbers in zip(columns, table, strict=True)}


def _chosen(where: str, names: list[str], wanted: Sequence[tuple[Column, ...]]) -> list[tuple[int, Column]]:
    """Position and column of each wanted one; raises FesError unless the first line names it once."""
    columns = []
    for alternatives in wanted:
        column = next((column for column in alternatives if column.name in names), None)
        if column is None:
            needed = ", ".join(" or ".join(column.name for column in columns) for columns in wanted)
            raise FesError(f"{where}, line 1: must name the columns {needed}, got '{','.join(names)[:_SHOWN]}'")
        if names.count(column.name) > 1:
            raise FesError(f"{where}, line 1: names the column {column.name} twice")
        columns.append((names.index(column.name), column))
    return columns


def _number(where: str, line: int, column: Column, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        word = _WORDS.get(text.strip().lower())
        if word is None:
            raise FesError(
                f"{where}, line {line}: {column.name} must be {column.rule}, got '{text[:_SHOWN]}'"
            ) from None
        return word


def _check(where: str, lines: "array[int]", column: Column, values: Floats) -> None:
    """Raise FesError for the first value that a column may not hold."""
    is_allowed = np.isfinite(values) & (values >= column.low) & (values <= column.high)
    if column.is_whole:
        is_allowed &= values == np.rint(values)
    if not is_allowed.all():
        row = int(np.argmin(is_allowed))
        raise FesError(f"{where}, line {lines[row]}: {column.name} must be {column.rule}, got {values[row]:g}")
