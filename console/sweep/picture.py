"""A sweep as a figure: how many runs have reached each level by when, and the paired differences of these times."""

from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from console.analysis import figures
from console.sweep import comparison
from console.sweep.comparison import PairedDifference
from console.sweep.design import Design
from console.sweep.table import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STYLES = (
    (figures.BLUE, "-"),
    (figures.ORANGE, "--"),
    (figures.GREEN, "-."),
    ("#CC79A7", ":"),
    ("#56B4E9", (0, (6, 1))),
    ("#E69F00", (0, (4, 1, 1, 1, 1, 1))),
)
"""Of the cells, in turn: Okabe and Ito's palette, with dashes of their own."""

MOST_CELLS = 12
"""Beyond this nobody can tell the lines apart."""


def drawable(design: Design, rows: list[Row]) -> bool:
    """Whether there is something to draw: a run at least has come to its end."""
    return bool(_outcomes(design, rows))


def sweep_figure(design: Design, rows: list[Row], differences: list[PairedDifference]) -> "Figure":
    """Above, by level, the share of a cell's runs that have reached it; below, what the cells differ by."""
    names = _outcomes(design, rows)
    cells = range(min(len(design.cells), MOST_CELLS))
    contrasts = list(dict.fromkeys((one.axis, one.base, one.other) for one in differences if one.other in cells))
    below = 0.9 + 0.28 * len(contrasts) if contrasts else 0.0
    height = 2.6 + 0.22 * -(-len(cells) // 3) + below
    ratios = (2.4, below) if contrasts else (1.0,)
    with figures.sheet(max(5.2, 2.5 * len(names)), height, len(names), ratios) as (figure, panels):
        grid = np.reshape(panels, (len(ratios), len(names)))
        for column, name in enumerate(names):
            _shares(grid[0, column], design, comparison.values(design, rows, name)[list(cells)])
            grid[0, column].set(title=name.removeprefix("time_to."), xlabel="time [s]")
            if contrasts:
                found = {(one.axis, one.base, one.other): one for one in differences if one.outcome == name}
                _intervals(grid[1, column], [found[pair] for pair in contrasts])
                grid[1, column].set_yticks(range(len(contrasts)), _titles(design, contrasts, column == 0))
            grid[0, column].tick_params(labelleft=column == 0)
        grid[0, 0].set(ylabel="share of runs")
        lines, labels = grid[0, 0].get_legend_handles_labels()
        title = figures.plain(", ".join(design.axes)) or None
        figure.legend(lines, labels, loc="outside upper left", ncols=3, frameon=False, title=title, alignment="left")
    return figure


def _outcomes(design: Design, rows: list[Row]) -> list[str]:
    """The levels that some run has reached, or one if none has."""
    names = [name for name in comparison.outcomes(design, rows) if name.startswith("time_to.")]
    return [name for name in names if np.isfinite(comparison.values(design, rows, name)).any()] or names[:1]


def _shares(axes: "Axes", design: Design, times: Any) -> None:
    """Steps of the empirical distribution; a cell whose runs do not all arrive stays below 1."""
    latest = np.nanmax(times) if np.isfinite(times).any() else 1.0
    for cell, ((color, dashes), found) in enumerate(zip(cycle(STYLES), times, strict=False)):
        there = np.sort(found[np.isfinite(found)])
        share = np.arange(len(there) + 1) / len(found)
        axes.step(
            np.concatenate(([0.0], there, [1.05 * latest])),
            np.append(share, share[-1]),
            where="post",
            color=color,
            linestyle=dashes,
            linewidth=1.4,
            label=figures.plain(design.title(cell)),
        )
    axes.set(ylim=(0.0, 1.05), xlim=(0.0, 1.05 * latest))
    axes.grid(alpha=0.3)


def _intervals(axes: "Axes", found: list[PairedDifference]) -> None:
    axes.axvline(0.0, color=figures.INK, linewidth=0.8, linestyle=":")
    for at, one in enumerate(found):
        color, _ = STYLES[one.other % len(STYLES)]
        if np.isfinite(one.low):
            axes.plot([one.low, one.high], [at, at], "-", color=color, linewidth=2.0, solid_capstyle="butt")
        axes.plot(one.mean, at, "o", color=figures.INK, markersize=4)
    axes.set(ylim=(len(found) - 0.5, -0.5), xlabel="paired difference [s]")
    axes.margins(x=0.15)
    axes.grid(alpha=0.3, axis="x")


def _titles(design: Design, contrasts: list[tuple[int, int, int]], shown: bool) -> list[str]:
    titles = (map(figures.plain, design.contrast(*contrast)) for contrast in contrasts)
    return [f"{what}\n({at})" if at else what for what, at in titles] if shown else [""] * len(contrasts)
