"""Figures with matplotlib, as PNG and SVG: readable in gray and for color-blind readers.

Matplotlib comes with the extra `plot`, and is imported only to draw a figure.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from console.analysis import history
from console.analysis.convergence_study import CHANGE, Learning
from console.analysis.history import History
from fes.errors import FesError
from fes.model import objective, outage
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.system.distribution import install
from fes.system.output import printable
from world.metrics.optimum import optimal_separation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation

# Okabe and Ito's palette; every line differs in its dashes too.
INK, BLUE, ORANGE, GREEN = "#000000", "#0072B2", "#D55E00", "#009E73"
DASHES = {BLUE: "-", ORANGE: "--", GREEN: "-."}

POINTS = {"A": 68.0, "B": 105.0, "C": 150.0}
"""The paper's points of Fig. 1 [m]."""

MARGIN = 25.0
"""Margin around the robots of a formation figure [m]."""

THIN = 10
"""One tick in this many is drawn in a figure of many lines."""

MOST_TEXTS = 6
"""Largest number of events whose texts are shown."""

LATE = 0.85
"""Share of the run after which the text of an event stands left of its mark."""

FLOOR = 1e-6
"""Smallest value of a logarithmic axis [m]."""


def require() -> None:
    """Raise FesError if matplotlib is missing."""
    if find_spec("matplotlib") is None:
        raise FesError(f"figures need matplotlib: {install('plot')}")


def outage_figure() -> "Figure":
    """The paper's Fig. 1: outage probability against separation, with its points A, B and C."""
    channel = ChannelConfig()
    r = np.linspace(0.0, 250.0, 501)
    with sheet(5.2, 3.4) as (figure, axes):
        axes.plot(r, outage.outage_probability(r, channel), color=BLUE)
        for name, separation in POINTS.items():
            lost = float(outage.outage_probability(np.array([separation]), channel)[0])
            axes.plot(separation, lost, "o", color=INK, markersize=5)
            axes.annotate(
                f"{name}: {separation:.0f} m, {100 * lost:.1f} %",
                (separation, lost),
                (8, -10),
                textcoords="offset points",
            )
        axes.set(xlabel="separation [m]", ylabel="outage probability", xlim=(0, 250), ylim=(0, 1))
    return figure


def index_figure() -> "Figure":
    """The paper's Fig. 3: the performance index for both minimum separations, with the optima."""
    channel = ChannelConfig()
    r = np.linspace(0.1, 250.0, 1000)
    with sheet(5.2, 3.4) as (figure, axes):
        for nearest, color, offset in ((50.0, BLUE, (8, 2)), (100.0, ORANGE, (-40, -64))):
            objective = ObjectiveConfig(minimum_separation=nearest)
            best = optimal_separation(objective, channel)
            top = float(_index(np.array([best]), objective, channel)[0])
            axes.plot(
                r, _index(r, objective, channel), DASHES[color], color=color, label=f"$r_{{min}}$ = {nearest:.0f} m"
            )
            axes.plot(best, top, "o", color=INK, markersize=5)
            axes.annotate(f"{best:.2f} m, J = {top:.3f}", (best, top), offset, textcoords="offset points")
        axes.set(xlabel="separation [m]", ylabel="performance index J", xlim=(0, 250), ylim=(0, 1))
        axes.legend(frameon=False)
    return figure


def formation_figure(run: History) -> "Figure":
    """The paper's Fig. 5: formation and links at the first contacts, on the way and at the end."""
    last = len(run.time) - 1
    first = next((tick for tick, links in enumerate(run.links) if len(links)), 0)
    low, high = run.poses[..., :2].min(axis=(0, 1)) - MARGIN, run.poses[..., :2].max(axis=(0, 1)) + MARGIN
    shown_ticks = sorted({first, min(last, first + last // 12), last})
    height = max(2.2, 0.6 + 3.6 * float((high[1] - low[1]) / (high[0] - low[0])))
    with sheet(3.8 * len(shown_ticks), min(height, 5.0), columns=len(shown_ticks)) as (figure, axes):
        for tick, panel in zip(shown_ticks, np.atleast_1d(axes), strict=True):
            tail = run.poses[: tick + 1]
            panel.plot(tail[:, :, 0], tail[:, :, 1], "-", color="#999999", linewidth=0.8)
            for link in history.ends_at(run, tick):
                panel.plot(link[:, 0], link[:, 1], "-", color=BLUE, linewidth=1.2)
            _robots(panel, run.poses[tick])
            panel.set(title=f"t = {run.time[tick]:.2f} s", xlabel="x [m]", ylabel="y [m]", aspect="equal")
            panel.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    return figure


def convergence_figure(run: History) -> "Figure":
    """The paper's Fig. 6 (a) and (b), and (c), the largest separation error; of a configuration, against r_beta."""
    averaged = "\naveraged over a dither period" if run.averaged else ""
    series = (
        (r"(a) disagreement $\sum|\hat r_{ij}-\hat r_{ji}|$ [m]", run.disagreement),
        (rf"(b) estimate errors $\sum|\hat r_{{ij}}-{run.optimum}|$ [m]", run.estimate_error),
        (rf"(c) largest separation error $|r_{{ij}}-{run.optimum}|$ [m]{averaged}", run.separation_error),
    )
    with sheet(10.8, 3.2, columns=3) as (figure, axes):
        for panel, (title, values) in zip(axes, series, strict=True):
            panel.semilogy(run.time, np.maximum(values, FLOOR), color=BLUE, linewidth=1.2)
            panel.axhline(1.0, color=INK, linewidth=0.8, linestyle=":")
            panel.set(title=title, xlabel="time [s]", xlim=(0.0, run.time[-1]))
            panel.grid(alpha=0.3)
            mark_events(panel, run)
    return figure


def mark_events(axes: "Axes", run: History) -> "list[Annotation]":
    """Mark the events of a run on an axis of time; returns their texts, which are shown if they are few."""
    from matplotlib.patheffects import withStroke

    times = [run.scenario.run.dt * event.tick for event in run.events]
    for time in times:
        axes.axvline(time, color=INK, linewidth=0.8, linestyle=":")
    style: Any = {
        "textcoords": "offset points", "rotation": 90, "fontsize": 7, "va": "top",
        "path_effects": [withStroke(linewidth=2.0, foreground="white")],
    }  # fmt: skip
    place = axes.get_xaxis_transform()
    texts = []
    for time, event in zip(times, run.events, strict=True) if len(times) <= MOST_TEXTS else ():
        is_late = time > LATE * run.time[-1]
        shift = (-2, -2) if is_late else (2, -2)
        side = "right" if is_late else "left"
        texts.append(axes.annotate(plain(event.text), (time, 1.0), shift, place, ha=side, **style))
    return texts


def step_figure(sub_steps: dict[str, list[tuple[float, float]]], ticks: list[tuple[float, float]]) -> "Figure":
    """Integration errors: the seeking law against its sub-step, the closed loop against the tick."""
    with sheet(7.2, 3.2, columns=2) as (figure, axes):
        for (transform, rows), color in zip(sub_steps.items(), (BLUE, ORANGE), strict=True):
            steps, errors = np.array(rows).T
            label = "J" if transform == "none" else "ln J"
            axes[0].loglog(1e3 * steps, errors, DASHES[color], marker="o", color=color, label=label)
        axes[0].set(xlabel="sub-step [ms]", ylabel="estimate error / travel", title="seeking law (18)")
        axes[0].legend(frameon=False)
        steps, errors = np.array(ticks).T
        axes[1].loglog(1e3 * steps, errors, "-", marker="o", color=BLUE)
        axes[1].set(
            xlabel="tick [ms]", ylabel="distance after 6 s [m]", title="closed loop, neighborhood.toml, no loss"
        )
        for panel, shown in ((axes[0], [2.5, 5, 10, 20]), (axes[1], [5, 10, 20, 50])):
            panel.set_xticks(shown, [f"{tick:g}" for tick in shown])
            panel.set_xticks([], minor=True)
        axes[1].set_yticks([0.5, 1, 2, 5], ["0.5", "1", "2", "5"])
        axes[1].set_yticks([], minor=True)
        for panel in axes:
            panel.grid(alpha=0.3)
    return figure


def learning_figure(learning: Learning) -> "Figure":
    """Mean estimates of robots that count beacons, beside the lower bound and beside (18) fed with samples."""
    with sheet(7.6, 3.4, columns=2) as (figure, axes):
        jump = int(np.searchsorted(learning.time, CHANGE))
        spans = (slice(0, jump), slice(jump, None))
        titles = ("from the start", "after the signal-to-noise ratio halved")
        for panel, span, title in zip(axes, spans, titles, strict=True):
            time = learning.time[span] - learning.time[span][0]
            panel.fill_between(
                time, -learning.bound[span], learning.bound[span], color="#cccccc", label="lower bound (1 σ)"
            )
            time = time[::THIN]
            for number, run in enumerate(learning.fed[:, span]):
                panel.plot(time, run[::THIN], ":", color=ORANGE, label=None if number else "(18), given samples")
            for number, run in enumerate(learning.counted[:, span]):
                panel.plot(time, run[::THIN], color=BLUE, linewidth=0.6, label=None if number else "counting beacons")
            panel.axhline(0.0, color=INK, linewidth=0.8)
            panel.set(title=title, xlabel="time [s]", xlim=(0.0, 45.0), ylim=(-10.0, 14.0))
            panel.grid(alpha=0.3)
        axes[0].set(ylabel=r"mean estimate $-\; r^*$ [m]")
        axes[0].legend(frameon=False, loc="upper right")
    return figure


def plain(text: str) -> str:
    """Data as a label: matplotlib reads text between dollars as a formula, and hides labels that begin with `_`.

    >>> plain("_$a$")
    ' _\\\\$a\\\\$'
    """
    shown = printable(text).replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def save(figure: "Figure", path: Path) -> list[Path]:
    """Write a figure as PNG and SVG beside each other; the same figure gives the same bytes."""
    from matplotlib import rc_context

    written = [path.with_suffix(".png"), path.with_suffix(".svg")]
    figure.savefig(written[0], dpi=150)
    with rc_context({"svg.hashsalt": "fes"}):  # ids in the picture are random otherwise
        figure.savefig(written[1], metadata={"Date": None})
    return written


def _index(r: Any, objective_config: ObjectiveConfig, channel: ChannelConfig) -> Any:
    return objective.preference(r, objective_config) * outage.reception_probability(r, channel)


def _robots(axes: "Axes", poses: Any) -> None:
    axes.quiver(
        poses[:, 0], poses[:, 1], np.cos(poses[:, 2]), np.sin(poses[:, 2]), color=ORANGE, width=0.006, zorder=3
    )
    axes.plot(poses[:, 0], poses[:, 1], "o", color=INK, markersize=4, zorder=4)
    if len(poses) <= 30:
        for robot, (x, y) in enumerate(poses[:, :2]):
            axes.annotate(str(robot), (x, y), (4, 4), textcoords="offset points", fontsize=8)


@contextmanager
def sheet(
    width: float, height: float, columns: int = 1, rows: tuple[float, ...] = (1.0,)
) -> Iterator[tuple["Figure", Any]]:
    """A new figure [inches] in the project's style, with its axes; `rows` are the ratios of their heights."""
    require()
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    style: Any = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False}
    with rc_context(style):
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure, figure.subplots(len(rows), columns, height_ratios=rows)
