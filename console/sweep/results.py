"""Results of a sweep: its rows, the cells and their paired differences, and the files that hold them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

from console.sweep import comparison, table
from console.sweep.comparison import PairedDifference, Spread
from console.sweep.design import Design
from console.sweep.table import Format, Row
from console.sweep.work import Done


@dataclass(frozen=True, eq=False)
class Results:
    """Rows of the runs, and their comparison."""

    design: Design
    rows: list[Row]
    """One per run, in the order of the design."""
    spreads: list[Spread]
    differences: list[PairedDifference]

    @classmethod
    def of(cls, design: Design, done: Mapping[str, Done]) -> Self:
        """The results of a design whose runs are all `done`."""
        rows = table.rows(design, done)
        spreads, differences = comparison.spreads(design, rows), comparison.differences(design, rows)
        return cls(design, rows, list(spreads), list(differences))

    def cell_rows(self) -> list[Row]:
        """One row per cell and outcome."""
        return [_cell(self.design, spread) for spread in self.spreads]

    def difference_rows(self) -> list[Row]:
        """One row per pair of cells and outcome."""
        return [_contrast(self.design, difference) for difference in self.differences]

    def write(self, directory: Path, form: Format = Format.CSV) -> list[Path]:
        """Write the tables into a directory, that of the runs in the given form; returns their files."""
        written = [
            table.write(directory, "table", self.rows, form),
            table.write(directory, "cells", self.cell_rows()),
        ]
        if self.differences:
            written.append(table.write(directory, "differences", self.difference_rows()))
        return written


def _cell(design: Design, spread: Spread) -> Row:
    columns = asdict(spread)
    return dict(zip(design.axes, design.cells[columns.pop("cell")].values, strict=True)) | columns


def _contrast(design: Design, difference: PairedDifference) -> Row:
    """A row of differences.csv: the axis, its two values, and the values of the other axes."""
    base, compared = (
        dict(zip(design.axes, design.cells[cell].values, strict=True))
        for cell in (difference.base, difference.compared)
    )
    axis = design.axes[difference.axis]
    columns = {"other" if name == "compared" else name: value for name, value in asdict(difference).items()}
    columns |= {"axis": axis, "base": base[axis], "other": compared[axis]}
    return columns | {f"at {held}": value if held != axis else None for held, value in base.items()}
