"""One row per run, in the order of the design.

The bytes do not depend on the machines: the table holds no wall-clock time and no name of a worker.
"""

import csv
import os
from collections.abc import Mapping, Sequence
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
"""Columns of text, even without a value; other columns without a value are numbers, so that all tables agree."""

Row = dict[str, Value]


class Format(StrEnum):
    """File format of a table."""

    CSV = "csv"
    PARQUET = "parquet"


def require(form: Format) -> None:
    """Raise FesError if this format needs a missing library."""
    if form is Format.PARQUET and find_spec("pyarrow") is None:
        raise FesError(f"--format parquet needs pyarrow: {install('parquet')}")


def rows(design: Design, done: Mapping[str, Done]) -> list[Row]:
    """The table: axes, seed, scalars of the summary, and error of each run."""
    table = []
    for run in design.runs:
        result = done[run.key]
        given = dict(zip(design.axes, design.cells[run.cell].values, strict=True))
        table.append(result.scalars | given | {SEED: run.seed, ERROR: result.error})
    columns = dict.fromkeys([*design.axes, SEED, *(name for row in table for name in row)])
    del columns[ERROR]
    return [{name: row.get(name) for name in (*columns, ERROR)} for row in table]


def write(directory: Path, name: str, table: Sequence[Row], form: Format = Format.CSV) -> Path:
    """Write a table atomically; a number that is not finite is empty, like a missing number."""
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


def write_page(directory: Path, name: str, text: str) -> Path:
    """Write a text atomically."""
    path, temporary = directory / name, directory / f".{name}"
    temporary.write_text(text, encoding="utf-8")
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
    """A column with the narrowest type of all its values; numbers for a column without values."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {bool}:
        return values, arrow.bool_()
    if kinds == {int}:
        return values, arrow.int64()
    if kinds <= {int, float, bool} and (kinds or name not in TEXTS):
        return [None if value is None else float(value) for value in values], arrow.float64()
    return [None if value is None else str(value) for value in values], arrow.string()
