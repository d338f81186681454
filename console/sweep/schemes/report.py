"""The table of schemes, for a terminal and as Markdown."""

import math

from rich.console import Group, RenderableType
from rich.table import Table

from console.sweep.comparison import CONFIDENCE
from console.sweep.schemes.outcomes import Mean, SchemeTable
from console.terminal.formatting import UNKNOWN
from console.terminal.printing import cell

SECOND = "told the channel"
"""Title of the second column."""

AT_ONCE = 3
"""Largest number of columns beside each other on the screen."""

WIDEST = 24
"""Largest width that keeps a word of a name whole on the screen."""

CAPTION = f"mean over the seeds ± half its {100 * CONFIDENCE:g} % interval"


def render(schemes: SchemeTable) -> RenderableType:
    """The table for a terminal: in parts of a few columns each, so that it fits 80 characters."""
    parts: list[RenderableType] = []
    words = [word for row in schemes.rows for word in row.name.split()]
    for first in range(0, len(schemes.columns), AT_ONCE):
        shown = slice(first, first + AT_ONCE)
        table = Table(box=None, padding=(0, 2, 0, 0))
        table.add_column(cell("scheme"), overflow="fold", min_width=min(max(map(len, words)), WIDEST))
        if first == 0:
            table.add_column(cell(SECOND), overflow="fold")
        for column in schemes.columns[shown]:
            table.add_column(cell(column.title), justify="right", overflow="fold")
        for row in schemes.rows:
            second = [_yes(row.is_told)] if first == 0 else []
            table.add_row(cell(row.name), *second, *map(text, row.means[shown]))
        parts += [table, ""]
    return Group(*parts, CAPTION)


def markdown(schemes: SchemeTable) -> str:
    """The table as Markdown."""
    head = ["scheme", SECOND, *(column.title for column in schemes.columns)]
    body = [[row.name, _yes(row.is_told), *map(text, row.means)] for row in schemes.rows]
    lines = [head, ["---", "---", *["---:"] * len(schemes.columns)], *body]
    return "".join("| " + " | ".join(entry.replace("|", "\\|") for entry in line) + " |\n" for line in lines)


def text(mean: Mean) -> str:
    """A mean with three digits, half its interval, and the share of runs with a value if some have none.

    >>> text(Mean(0.84384, 0.8437, 0.844, 20, 20)), text(Mean(float("nan"), float("nan"), float("nan"), 0, 20))
    ('0.844 ± 0.000', '– (0/20)')
    """
    share = "" if mean.reached == mean.runs else f" ({mean.reached}/{mean.runs})"
    if not math.isfinite(mean.mean):
        return UNKNOWN + share
    digits = 2 - math.floor(math.log10(abs(mean.mean))) if mean.mean else 3
    digits = min(max(digits, 0), 3)
    half = f" ± {0.5 * (mean.high - mean.low):.{digits}f}" if math.isfinite(mean.low) else ""
    return f"{mean.mean:.{digits}f}{half}{share}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
