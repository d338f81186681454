"""The plotted measures of a team, and the robots that its links depend on."""

import numpy as np

from console.measures import belief, links
from fes.arrays.types import Floats
from fes.protocol.report import Report
from world.metrics import graphs

SERIES = {
    "disagreement": "disagreement",
    "estimate_error_max": "estimate error",
    "separation_error_max": "separation error",
}
"""Plotted fields of a Report, and their labels."""


def series(report: Report) -> Floats:
    """The plotted values of a Report [3] [m]."""
    if report.is_of_robots:
        return belief.series(report)
    return np.array([getattr(report, name) for name in SERIES])


def labels(report: Report) -> tuple[str, ...]:
    """Labels of `series`, in its order."""
    return belief.SERIES if report.is_of_robots else tuple(SERIES.values())


def parts(report: Report) -> int:
    """Number of connected parts of the graph of the living robots and the links in use."""
    known = links.known_ends(report)
    return graphs.parts(report.alive == 1, report.a[known], report.b[known])
