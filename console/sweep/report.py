"""The comparison of a sweep as tables for a terminal."""

import math

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from console.sweep import comparison
from console.sweep.comparison import METRICS, PairedDifference, Spread
from console.sweep.design import Design
from console.terminal.formatting import UNKNOWN
from console.terminal.printing import cell
from fes.model.quantities import SUMMARY

MOST_ROWS = 36
"""Maximum number of rows of a table on the screen; the files hold all."""

SHOWN = (METRICS, "team_index", "cutting_robots", "time_to.", "separation_error_max")
"""Prefixes of the outcomes shown, in their order; the files hold all outcomes."""

UNITS = {quantity.name: quantity.unit for quantity in SUMMARY}
"""Outcome -> its unit."""


def render(design: Design, spreads: list[Spread], differences: list[PairedDifference]) -> RenderableType:
    """Statistics of each cell, and the paired differences between cells."""
    outcomes = dict.fromkeys(spread.outcome for spread in spreads)
    names = [name for prefix in SHOWN for name in outcomes if name.startswith(prefix)]
    parts: list[RenderableType] = [_cells(design, names, spreads)]
    if differences:
        parts += ["", _differences(design, names, differences)]
    return Group(*parts)


def _cells(design: Design, names: list[str], spreads: list[Spread]) -> Table:
    table = _table(", ".join(design.axes) or "outcome", "reached", "median", "mean", "largest")
    rows = [spread for name in names for spread in spreads if spread.outcome == name]
    for index, spread in enumerate(rows[:MOST_ROWS]):
        if index == 0 or rows[index - 1].outcome != spread.outcome:
            table.add_row(_name(spread.outcome))
        numbers = map(_number, (spread.median, spread.mean, spread.largest))
        table.add_row(cell(f"  {design.title(spread.cell)}"), f"{spread.reached}/{spread.runs}", *numbers)
    return _cut(table, len(rows), "cells.csv")


def _differences(design: Design, names: list[str], differences: list[PairedDifference]) -> Table:
    table = _table("paired difference", "pairs", "mean", f"{100 * comparison.CONFIDENCE:g} % interval")
    rows = [difference for name in names for difference in differences if difference.outcome == name]
    for index, difference in enumerate(rows[:MOST_ROWS]):
        if index == 0 or rows[index - 1].outcome != difference.outcome:
            table.add_row(_name(difference.outcome))
        bounds = (
            f"{_number(difference.low, '+')} to {_number(difference.high, '+')}"
            if math.isfinite(difference.low)
            else UNKNOWN
        )
        text, at_others = design.contrast(difference.axis, difference.base, difference.compared)
        label = f"  {text} ({at_others})" if at_others else f"  {text}"
        table.add_row(cell(label), str(difference.pairs), _number(difference.mean, "+"), bounds)
    return _cut(table, len(rows), "differences.csv")


def _table(heading: str, *numbers: str) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0))
    table.add_column(cell(heading), overflow="fold")
    for name in numbers:
        table.add_column(cell(name), justify="right", no_wrap=True)
    return table


def _name(outcome: str) -> Text:
    if outcome.startswith(METRICS):
        return cell(outcome, "bold")
    unit = UNITS[outcome]
    return cell(f"{outcome} [{unit}]", "bold")


def _cut(table: Table, rows: int, file: str) -> Table:
    if rows > MOST_ROWS:
        table.caption = f"… and {rows - MOST_ROWS} more in {file}"
    return table


def _number(value: float, sign: str = "") -> str:
    if not math.isfinite(value):
        return UNKNOWN
    return f"{value:{sign}.3g}"
