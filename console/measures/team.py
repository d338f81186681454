"""The plotted measures of a team, the robots that views draw, and the parts into which the links join them."""

import numpy as np

from console.measures import belief, links
from fes.arrays.types import Bools, Floats
from fes.protocol.report import Report
from world.metrics import graphs

SERIES = {
    "disagreement": "disagreement",
    "estimate_error_max": "estimate error",
    "separation_error_max": "separation error",
}
"""Plotted fields of a Report, and their labels."""

FARTHEST = 1e9
"""Robots beyond this x or y are not drawn [m]."""


def series(report: Report) -> Floats:
    """The plotted values of a Report [3] [m]."""
    if report.is_of_robots:
        return belief.series(report)
    return np.array([getattr(report, name) for name in SERIES])


def labels(report: Report) -> tuple[str, ...]:
    """Labels of `series`, in its order."""
    return belief.SERIES if report.is_of_robots else tuple(SERIES.values())


def on_map(report: Report) -> Bools:
    """True for each robot [n] whose position is known, and not absurd."""
    inside: Bools = np.all(np.abs(report.poses[:, :2]) < FARTHEST, axis=1)  # false for NaN
    return inside


def parts(report: Report) -> int:
    """Number of connected parts of the graph of the living robots and the links in use."""
    known = links.known_ends(report)
    return graphs.parts(report.alive == 1, report.a[known], report.b[known])
