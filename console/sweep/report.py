"""What a sweep found, as a person reads it."""

import math

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from console.sweep import comparison
from console.sweep.comparison import PairedDifference, Spread
from console.sweep.design import Design
from console.terminal.formatting import UNKNOWN
from console.terminal.printing import cell

MOST_ROWS = 36
"""Of a table on the screen; the files have all."""

SHOWN = ("time_to.", "separation_error_max")
"""How the names of the outcomes begin that are shown; the files have all."""


def render(design: Design, spreads: list[Spread], differences: list[PairedDifference]) -> RenderableType:
    """Each cell by itself, and the paired differences between cells."""
    found = dict.fromkeys(one.outcome for one in spreads)
    names = [name for shown in SHOWN for name in found if name.startswith(shown)]
    parts: list[RenderableType] = [_cells(design, names, spreads)]
    if differences:
        parts += ["", _differences(design, names, differences)]
    return Group(*parts)


def _cells(design: Design, names: list[str], spreads: list[Spread]) -> Table:
    table = _table(", ".join(design.axes) or "outcome", "reached", "median", "mean", "largest")
    rows = [one for name in names for one in spreads if one.outcome == name]
    for at, one in enumerate(rows[:MOST_ROWS]):
        if at == 0 or rows[at - 1].outcome != one.outcome:
            table.add_row(_name(one.outcome))
        numbers = map(_number, (one.median, one.mean, one.largest))
        table.add_row(cell(f"  {design.title(one.cell)}"), f"{one.reached}/{one.runs}", *numbers)
    return _cut(table, len(rows), "cells.csv")


def _differences(design: Design, names: list[str], differences: list[PairedDifference]) -> Table:
    table = _table("paired difference", "pairs", "mean", f"{100 * comparison.CONFIDENCE:g} % interval")
    rows = [one for name in names for one in differences if one.outcome == name]
    for at, one in enumerate(rows[:MOST_ROWS]):
        if at == 0 or rows[at - 1].outcome != one.outcome:
            table.add_row(_name(one.outcome))
        bounds = f"{_number(one.low, '+')} to {_number(one.high, '+')}" if math.isfinite(one.low) else UNKNOWN
        difference, at_others = design.contrast(one.axis, one.base, one.other)
        what = f"  {difference} ({at_others})" if at_others else f"  {difference}"
        table.add_row(cell(what), str(one.pairs), _number(one.mean, "+"), bounds)
    return _cut(table, len(rows), "differences.csv")


def _table(what: str, *numbers: str) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0))
    table.add_column(cell(what), overflow="fold")
    for name in numbers:
        table.add_column(cell(name), justify="right", no_wrap=True)
    return table


def _name(outcome: str) -> Text:
    unit = "s" if outcome.startswith("time_to.") else "m"
    return cell(f"{outcome} [{unit}]", "bold")


def _cut(table: Table, rows: int, file: str) -> Table:
    if rows > MOST_ROWS:
        table.caption = f"… and {rows - MOST_ROWS} more in {file}"
    return table


def _number(value: float, sign: str = "") -> str:
    if not math.isfinite(value):
        return UNKNOWN
    return f"{value:{sign}.3g}"
