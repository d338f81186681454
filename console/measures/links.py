"""Errors and losses of the links in use, and the classes by which views draw them."""

import numpy as np

from console.measures import belief
from fes.arrays.types import Bools, Floats, Ints
from fes.protocol.report import Report

FAIR_OUTAGE, POOR_OUTAGE = 0.15, 0.35
"""Outage probabilities from which a link is fair, and poor."""


def outage_class(outage: Floats) -> Ints:
    """Class of each link [l]: 0 good, 1 fair, 2 poor or unknown.

    >>> outage_class(np.array([0.1, 0.2, 0.5, np.nan])).tolist()
    [0, 1, 2, 2]
    """
    return np.where(outage < FAIR_OUTAGE, 0, np.where(outage < POOR_OUTAGE, 1, 2))


def loss(report: Report) -> Floats:
    """Outage of each link [l]; of real robots the share of their beacons that did not decode."""
    return belief.lost(report) if report.is_of_robots else report.outage


def counted(report: Report) -> Floats:
    """Share of each link's beacons that decoded [l]; NaN before the first beacon."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share: Floats = report.decoded / report.sent
    return share


def errors(report: Report) -> Floats:
    """Separation less r* [l] [m]; of real robots, less their own estimate of the link."""
    if report.is_of_robots:
        return belief.formation_errors(report)
    with np.errstate(invalid="ignore"):
        error: Floats = report.separation - report.optimal_separation
    return error


def known_ends(report: Report) -> Bools:
    """True for each link both of whose ends are robots of the report [l]."""
    known: Bools = (np.minimum(report.a, report.b) >= 0) & (np.maximum(report.a, report.b) < len(report.alive))
    return known
