"""The table of schemes as a figure: a panel for each column, a line for each scheme."""

import math
import textwrap
from typing import TYPE_CHECKING

from console.analysis import figures
from console.sweep.schemes.outcomes import SchemeOutcomes, SchemeTable
from world.config.outside.schemes import ColumnConfig

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = 20
"""Largest width of a line of a title [characters]."""

PER_ROW = 4
"""Largest number of panels beside each other."""


def schemes_figure(schemes: SchemeTable) -> "Figure":
    """The means with their intervals. Open marks: schemes that are told the channel. Dotted lines: the best mean."""
    columns, rows = schemes
    across = min(PER_ROW, len(columns))
    down = math.ceil(len(columns) / across)
    with figures.sheet(1.6 + 2.0 * across, (0.7 + 0.2 * len(rows)) * down, across, (1.0,) * down) as (figure, axes):
        panels = axes.flat if hasattr(axes, "flat") else [axes]
        for index, panel in enumerate(panels):
            if index >= len(columns):
                panel.set_axis_off()
                continue
            _panel(panel, columns[index], index, rows)
            shown = [figures.plain(row.name) for row in rows] if index % across == 0 else [""] * len(rows)
            panel.set_yticks(range(len(rows)), shown)
    return figure


def _panel(axes: "Axes", column: ColumnConfig, index: int, rows: list[SchemeOutcomes]) -> None:
    means = [row.means[index] for row in rows]
    finite = [mean.mean for mean in means if math.isfinite(mean.mean)]
    if finite:
        best = max(finite) if column.better == "larger" else min(finite)
        axes.axvline(best, color=figures.INK, linewidth=0.8, linestyle=":")
    for place, (row, mean) in enumerate(zip(rows, means, strict=True)):
        color = figures.ORANGE if row.is_told else figures.BLUE
        if math.isfinite(mean.low):
            axes.plot([mean.low, mean.high], [place, place], "-", color=color, linewidth=2.0)
        axes.plot(mean.mean, place, "o", color=color, markersize=4.5, fillstyle="none" if row.is_told else "full")
    axes.set(title=textwrap.fill(figures.plain(column.title), TITLE), ylim=(len(rows) - 0.5, -0.5))
    axes.margins(x=0.1)
    axes.grid(alpha=0.3)
