"""What a sweep found, as a person reads it."""

import math
from collections.abc import Iterable

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from console.sweep import comparison
from console.sweep.comparison import Difference, Spread
from console.sweep.design import Design
from console.text import UNKNOWN

MOST_ROWS = 30
"""Of a table on the screen; the files have all."""

SHOWN = ("time_to.", "separation_error_max")
"""How the names of the outcomes begin that are shown; the files have all."""


def render(design: Design, spreads: list[Spread], differences: list[Difference]) -> RenderableType:
    """Medians by cell, and paired differences between cells."""
    names = [name for name in dict.fromkeys(one.outcome for one in spreads) if name.startswith(SHOWN)]
    parts: list[RenderableType] = [_cells(design, names, spreads)]
    if differences:
        parts += ["", _differences(design, names, differences)]
    return Group(*parts)


def _cells(design: Design, names: list[str], spreads: list[Spread]) -> Table:
    seeds = len(design.seeds)
    title = f"median over {seeds} seed{'' if seeds == 1 else 's'} (where fewer reached it: how many)"
    table = _table(title, list(design.axes) or ["scenario"], names)
    by_cell = {(one.cell, one.outcome): one for one in spreads}
    for at, cell in enumerate(design.cells[:MOST_ROWS]):
        told = [_median(by_cell[at, name]) for name in names]
        table.add_row(*map(_plain, cell.values or (design.name,)), *told)
    return _cut(table, len(design.cells), "cells.csv")


def _differences(design: Design, names: list[str], differences: list[Difference]) -> Table:
    percent = f"{100 * comparison.CONFIDENCE:g}"
    table = _table(
        f"mean paired difference, with its {percent} % confidence interval (where fewer pairs: how many)",
        ["compared"],
        names,
    )
    contrasts = dict.fromkeys((one.base, one.other) for one in differences)
    by_contrast = {(one.base, one.other, one.outcome): one for one in differences}
    for base, other in list(contrasts)[:MOST_ROWS]:
        told = [_mean(by_contrast[base, other, name], len(design.seeds)) for name in names]
        table.add_row(_plain(f"{design.title(other)} - {design.title(base)}"), *told)
    return _cut(table, len(contrasts), "differences.csv")


def _table(title: str, first: Iterable[str], names: list[str]) -> Table:
    table = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
    for name in first:
        table.add_column(_plain(name), overflow="fold")
    for name in names:
        unit = "s" if name.startswith("time_to.") else "m"
        table.add_column(_plain(f"{name.removeprefix('time_to.')} [{unit}]"), justify="right")
    return table


def _cut(table: Table, rows: int, file: str) -> Table:
    if rows > MOST_ROWS:
        table.caption = f"… and {rows - MOST_ROWS} more in {file}"
    return table


def _median(one: Spread) -> str:
    return _number(one.median) + (f" ({one.reached})" if one.reached < one.runs else "")


def _mean(one: Difference, seeds: int) -> str:
    half = 0.5 * (one.high - one.low)
    told = _number(one.mean, "+") + (f" ± {_number(half)}" if math.isfinite(half) else "")
    return told + (f" ({one.pairs})" if one.pairs < seeds else "")


def _number(value: float, sign: str = "") -> str:
    if not math.isfinite(value):
        return UNKNOWN
    digits = 2 if abs(value) >= 0.1 or value == 0.0 else 4
    return f"{value:{sign}.{digits}f}"


def _plain(value: object) -> str:
    return escape(UNKNOWN if value is None else str(value))
