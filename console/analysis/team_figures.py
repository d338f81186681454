"""Figures of the team index: of one run over time, and of the ends of several runs side by side."""

from typing import TYPE_CHECKING

import numpy as np

from console.analysis import history
from console.analysis.figures import BLUE, GREEN, INK, MARGIN, ORANGE, mark_events, plain, sheet
from console.analysis.history import History
from fes.arrays.types import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GRAY = "#999999"


def team_figure(run: History) -> "Figure":
    """The team index against its target, and the final configuration with the robots whose loss cuts its links."""
    with sheet(9.0, 3.8, columns=2) as (figure, axes):
        index, target = run.team
        axes[0].plot(run.time, index, color=BLUE, linewidth=1.4, label="team index F")
        axes[0].plot(run.time, target, "--", color=ORANGE, linewidth=1.4, label="target")
        axes[0].set(xlabel="time [s]", ylabel="team index", xlim=(0.0, run.time[-1]), ylim=(0.0, None))
        axes[0].grid(alpha=0.3)
        mark_events(axes[0], run)
        axes[0].legend(framealpha=1.0, edgecolor="none", loc="lower right")
        _end(axes[1], run, _frame([run]))
        axes[1].set_title(f"t = {run.time[-1]:.2f} s, {_cut(run)}")
    return figure


def ends_figure(runs: dict[str, History]) -> "Figure":
    """The common start of some runs, and the end of each, by its title."""
    frame = _frame(list(runs.values()))
    low, high = frame
    first = next(iter(runs.values()))
    height = 1.1 + 3.2 * float((high[1] - low[1]) / (high[0] - low[0]))
    with sheet(3.2 * (len(runs) + 1), height, columns=len(runs) + 1) as (figure, axes):
        axes[0].plot(first.poses[0, :, 0], first.poses[0, :, 1], "o", color=INK, markersize=4)
        _fit(axes[0], frame)
        axes[0].set_title("start\n")
        for panel, (name, run) in zip(axes[1:], runs.items(), strict=True):
            _end(panel, run, frame)
            panel.set_title(f"{plain(name)}\nF = {run.team[0, -1]:.3f}, {_cut(run)}")
    return figure


def _end(axes: "Axes", run: History, frame: tuple[Floats, Floats]) -> None:
    """The last configuration: a cutting robot is a square, an absent one a cross, any other one a dot."""
    axes.plot(run.poses[0, :, 0], run.poses[0, :, 1], "o", color=GRAY, markersize=3, markerfacecolor="none")
    for link in history.ends_at(run, len(run.time) - 1):
        axes.plot(link[:, 0], link[:, 1], "-", color=BLUE, linewidth=1.2)
    places = run.poses[-1, :, :2]
    is_cutting = np.isin(np.arange(len(places)), run.cutting)
    axes.plot(*places[run.present[-1] & ~is_cutting].T, "o", color=GREEN, markersize=5, zorder=4)
    axes.plot(*places[~run.present[-1]].T, "x", color=GRAY, markersize=5, zorder=3)
    axes.plot(*places[is_cutting].T, "s", color=ORANGE, markersize=7, markeredgecolor=INK, zorder=4)
    if len(places) <= 30:
        for robot, (x, y) in enumerate(places):
            axes.annotate(str(robot), (x, y), (5, 4), textcoords="offset points", fontsize=8)
    _fit(axes, frame)


def _fit(axes: "Axes", frame: tuple[Floats, Floats]) -> None:
    low, high = frame
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _frame(runs: list[History]) -> tuple[Floats, Floats]:
    """The lowest and the highest corner [m] around the starts and ends of some runs."""
    places = np.concatenate([run.poses[tick, :, :2] for run in runs for tick in (0, -1)])
    return places.min(axis=0) - MARGIN, places.max(axis=0) + MARGIN


def _cut(run: History) -> str:
    """The robots whose loss cuts the links, in words."""
    number = len(run.cutting)
    return f"{number or 'no'} cutting robot{'' if number == 1 else 's'}"
