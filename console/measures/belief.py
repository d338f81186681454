"""Measures of a team of real robots, whose truth is unknown: from their own estimates, poses and counts."""

import numpy as np

from fes.arrays.types import Floats
from fes.protocol.report import Report

SERIES = ("disagreement", "estimate spread", "formation error")
"""Plotted measures [m], in the order of `series`."""


@np.errstate(all="ignore")
def link_estimates(report: Report) -> Floats:
    """Mean estimate of both ends [l] [m]; that of one end where the other is unknown."""
    ab, ba = report.estimate_ab, report.estimate_ba
    mean: Floats = np.where(np.isnan(ab), ba, np.where(np.isnan(ba), ab, 0.5 * ab + 0.5 * ba))
    return mean


@np.errstate(all="ignore")
def mean_estimate(report: Report) -> float:
    """Mean of all estimates [m]; NaN without one."""
    known = _estimates(report)
    return float(known.mean()) if len(known) else float("nan")


@np.errstate(all="ignore")
def formation_errors(report: Report) -> Floats:
    """Separation less the estimate of each link [l] [m]."""
    error: Floats = report.separation - link_estimates(report)
    return error


@np.errstate(all="ignore")
def series(report: Report) -> Floats:
    """Disagreement, largest less smallest estimate, and largest |separation - estimate| [3] [m]; NaN if unknown."""
    estimates, errors = _estimates(report), np.abs(formation_errors(report))
    known = errors[np.isfinite(errors)]
    spread = np.ptp(estimates) if len(estimates) else np.nan
    return np.array([report.disagreement, spread, known.max() if len(known) else np.nan])


@np.errstate(all="ignore")
def lost(report: Report) -> Floats:
    """Share of each link's beacons that did not decode [l]; NaN before the first beacon."""
    share: Floats = 1.0 - report.decoded / report.sent
    return share


def _estimates(report: Report) -> Floats:
    both = np.concatenate([report.estimate_ab, report.estimate_ba])
    known: Floats = both[np.isfinite(both)]
    return known
