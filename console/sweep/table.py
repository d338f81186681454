"""One row a run, in the order of the design, the same bytes however and wherever the runs were carried out.

So nothing of the machine is in it: no wall-clock time, no name of a worker.
"""

import csv
import os
from collections.abc import Sequence
from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

from console.sweep.design import Design, Value
from console.sweep.work import Done
from fes.errors import FesError
from fes.system import strict_json
from fes.system.distribution import install

SEED, ERROR = "seed", "error"

TEXTS = frozenset({ERROR, "digest"})
"""Columns that are text even where no run has a value; others are numbers, so that two sweeps' tables are alike."""

Row = dict[str, Value]


class Format(StrEnum):
    """How the table is written."""

    CSV = "csv"
    PARQUET = "parquet"


def require(form: Format) -> None:
    """Raise FesError if this format cannot be written here."""
    if form is Format.PARQUET and find_spec("pyarrow") is None:
        raise FesError(f"--format parquet needs pyarrow: {install('parquet')}")


def rows(design: Design, done: dict[str, Done]) -> list[Row]:
    """The table: a run's axes, its seed, the scalars of its summary, and why it failed if it did."""
    found = []
    for run in design.runs:
        one = done[run.key]
        given = dict(zip(design.axes, design.cells[run.cell].values, strict=True))
        found.append(one.scalars | given | {SEED: run.seed, ERROR: one.error})
    columns = dict.fromkeys([*design.axes, SEED, *(name for row in found for name in row)])
    del columns[ERROR]
    return [{name: row.get(name) for name in (*columns, ERROR)} for row in found]


def write(directory: Path, name: str, table: Sequence[Row], form: Format = Format.CSV) -> Path:
    """Write a table, complete or not at all; a number that is not finite is empty, like a missing one."""
    table = [strict_json.finite(row) for row in table]
    path = directory / f"{name}.{form.value}"
    temporary = directory / f".{path.name}"
    if form is Format.PARQUET:
        _write_parquet(temporary, table)
    else:
        with temporary.open("w", encoding="utf-8", newline="") as file:
            _write_csv(file, table)
    os.replace(temporary, path)
    return path


def _write_csv(file: IO[str], table: Sequence[Row]) -> None:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(table[0] if table else [])
    for row in table:
        writer.writerow(str(value).lower() if isinstance(value, bool) else value for value in row.values())


def _write_parquet(path: Path, table: Sequence[Row]) -> None:
    import pyarrow
    from pyarrow import parquet

    columns = {name: [row[name] for row in table] for name in (table[0] if table else [])}
    parquet.write_table(
        pyarrow.table({name: pyarrow.array(*_typed(pyarrow, name, values)) for name, values in columns.items()}), path
    )


def _typed(arrow: Any, name: str, values: list[Value]) -> tuple[list[Value], Any]:
    """A column with its type: the narrowest that holds all its values; numbers where there are none."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {bool}:
        return values, arrow.bool_()
    if kinds == {int}:
        return values, arrow.int64()
    if kinds <= {int, float, bool} and (kinds or name not in TEXTS):
        return [None if value is None else float(value) for value in values], arrow.float64()
    return [None if value is None else str(value) for value in values], arrow.string()
