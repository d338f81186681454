"""The measurements and the fitted channel, as a figure."""

from typing import TYPE_CHECKING, Any

import numpy as np

from console.analysis import figures
from console.fit import shares
from console.fit.estimate import Fit
from console.fit.measurements import Packets, Powers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS = 400
MOST = 4000
"""Largest number of powers that are drawn."""

INTERVAL = "95 % interval"

LEGEND: Any = {"loc": "best", "framealpha": 1.0, "edgecolor": "none"}
"""A legend that hides the line of r* behind it."""


def figure_of(fit: Fit, measured: Packets | Powers) -> "Figure":
    """Measured shares with Wilson intervals, or received power, and the fitted curve with its band."""
    columns = 1 if isinstance(measured, Packets) else 2
    with figures.sheet(5.2 * columns, 3.4, columns) as (figure, panels):
        if isinstance(measured, Packets):
            _draw_curve(panels, fit, float(measured.separation.max()))
            _draw_shares(panels, measured)
            panels.legend(**LEGEND)
        else:
            _draw_powers(panels[0], fit, measured)
            _draw_curve(panels[1], fit, float(measured.separation.max()))
            for panel in panels:
                panel.legend(**LEGEND)
    return figure


def _draw_curve(axes: "Axes", fit: Fit, farthest: float) -> None:
    end = 1.05 * max(farthest, fit.optimal if np.isfinite(fit.optimal) else 0.0)
    separation = np.linspace(end / POINTS, end, POINTS)
    value, low, high = fit.band(separation)
    axes.fill_between(separation, low, high, color=figures.BLUE, alpha=0.2, linewidth=0.0, label=INTERVAL)
    axes.plot(separation, value, color=figures.BLUE, label=f"fit: {fit.settings['model']}")
    if np.isfinite(fit.optimal):
        axes.axvline(fit.optimal, color=figures.INK, linewidth=0.8, linestyle=":", label=f"r* = {fit.optimal:.2f} m")
    axes.set(xlabel="separation [m]", ylabel="reception probability", xlim=(0.0, end), ylim=(0.0, 1.02))


def _draw_shares(axes: "Axes", packets: Packets) -> None:
    measured = shares.by_separation(packets)
    ends = np.abs(np.array([measured.low, measured.high]) - measured.share)
    axes.errorbar(
        measured.separation, measured.share, ends,
        fmt="o", color=figures.ORANGE, markersize=4, linewidth=1.0, capsize=2, label="measured, Wilson interval",
    )  # fmt: skip


def _draw_powers(axes: "Axes", fit: Fit, powers: Powers) -> None:
    every = -(-len(powers.rssi) // MOST)
    axes.plot(
        powers.separation[::every], powers.rssi[::every], ".", color=figures.ORANGE, markersize=2, label="measured"
    )
    end = 1.05 * float(powers.separation.max())
    separation = np.linspace(float(powers.separation.min()), end, POINTS)
    # p = exp(-threshold / mean power); a float near 1 may hold no digit of that
    with np.errstate(divide="ignore"):
        means = [powers.threshold - 10.0 * np.log10(-np.log(values)) for values in fit.band(separation)]
    axes.fill_between(separation, means[1], means[2], color=figures.BLUE, alpha=0.2, linewidth=0.0, label=INTERVAL)
    axes.plot(separation, means[0], color=figures.BLUE, label="fit: mean power")
    axes.axhline(powers.threshold, color=figures.INK, linewidth=0.8, linestyle="--", label="least that decodes")
    low, high = float(powers.rssi.min()), float(powers.rssi.max())
    axes.set(xlabel="separation [m]", ylabel="received power [dBm]", xlim=(0.0, end), ylim=(low - 3.0, high + 3.0))
