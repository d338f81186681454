"""A sweep as a figure: share of runs that have reached each level over time, and paired differences of times."""

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
"""Colors and dashes of the cells, in rotation: Okabe and Ito's palette."""

MOST_CELLS = 12
"""Maximum number of cells drawn; more lines are indistinguishable."""


def drawable(design: Design, rows: list[Row]) -> bool:
    """True if there is an outcome to draw."""
    return bool(_outcomes(design, rows))


def sweep_figure(design: Design, rows: list[Row], differences: list[PairedDifference]) -> "Figure":
    """Above, by level, the share of each cell's runs that have reached it; below, the paired differences."""
    names = _outcomes(design, rows)
    cells = range(min(len(design.cells), MOST_CELLS))
    contrasts = list(
        dict.fromkeys(
            (difference.axis, difference.base, difference.compared)
            for difference in differences
            if difference.compared in cells
        )
    )
    below = 0.9 + 0.28 * len(contrasts) if contrasts else 0.0
    height = 2.6 + 0.22 * -(-len(cells) // 3) + below
    ratios = (2.4, below) if contrasts else (1.0,)
    with figures.sheet(max(5.2, 2.5 * len(names)), height, len(names), ratios) as (figure, panels):
        grid = np.reshape(panels, (len(ratios), len(names)))
        for column, name in enumerate(names):
            _shares(grid[0, column], design, comparison.values(design, rows, name)[list(cells)])
            grid[0, column].set(title=name.removeprefix("time_to."), xlabel="time [s]")
            if contrasts:
                by_contrast = {
                    (difference.axis, difference.base, difference.compared): difference
                    for difference in differences
                    if difference.outcome == name
                }
                _intervals(grid[1, column], [by_contrast[pair] for pair in contrasts])
                grid[1, column].set_yticks(range(len(contrasts)), _titles(design, contrasts, column == 0))
            grid[0, column].tick_params(labelleft=column == 0)
        grid[0, 0].set(ylabel="share of runs")
        lines, labels = grid[0, 0].get_legend_handles_labels()
        title = figures.plain(", ".join(design.axes)) or None
        figure.legend(lines, labels, loc="outside upper left", ncols=3, frameon=False, title=title, alignment="left")
    return figure


def _outcomes(design: Design, rows: list[Row]) -> list[str]:
    """The levels reached by at least one run; if there are none, the first level."""
    names = [name for name in comparison.outcomes(design, rows) if name.startswith("time_to.")]
    return [name for name in names if np.isfinite(comparison.values(design, rows, name)).any()] or names[:1]


def _shares(axes: "Axes", design: Design, times: Any) -> None:
    """Steps of the empirical distribution; a cell in which a run does not reach the level stays below 1."""
    latest = np.nanmax(times) if np.isfinite(times).any() else 1.0
    for cell, ((color, dashes), cell_times) in enumerate(zip(cycle(STYLES), times, strict=False)):
        reached = np.sort(cell_times[np.isfinite(cell_times)])
        share = np.arange(len(reached) + 1) / len(cell_times)
        axes.step(
            np.concatenate(([0.0], reached, [1.05 * latest])),
            np.append(share, share[-1]),
            where="post",
            color=color,
            linestyle=dashes,
            linewidth=1.4,
            label=figures.plain(design.title(cell)),
        )
    axes.set(ylim=(0.0, 1.05), xlim=(0.0, 1.05 * latest))
    axes.grid(alpha=0.3)


def _intervals(axes: "Axes", differences: list[PairedDifference]) -> None:
    axes.axvline(0.0, color=figures.INK, linewidth=0.8, linestyle=":")
    for row, difference in enumerate(differences):
        color, _ = STYLES[difference.compared % len(STYLES)]
        if np.isfinite(difference.low):
            axes.plot(
                [difference.low, difference.high], [row, row], "-", color=color, linewidth=2.0, solid_capstyle="butt"
            )
        axes.plot(difference.mean, row, "o", color=figures.INK, markersize=4)
    axes.set(ylim=(len(differences) - 0.5, -0.5), xlabel="paired difference [s]")
    axes.margins(x=0.15)
    axes.grid(alpha=0.3, axis="x")


def _titles(design: Design, contrasts: list[tuple[int, int, int]], shown: bool) -> list[str]:
    titles = (map(figures.plain, design.contrast(*contrast)) for contrast in contrasts)
    return (
        [f"{title}\n({others})" if others else title for title, others in titles] if shown else [""] * len(contrasts)
    )
