"""Reception against separation, as robots learn it and as it is: ln(-ln p) = level + exponent ln(r / rho_0)."""

import math

import numpy as np

from fes.arrays.types import Bools, Floats
from fes.protocol.report import Report

_LEAST, _MOST = 1e-3, 1e9  # m; separations outside are not drawn
_FLAT = 50.0  # beyond, exp(-exp(x)) is 0 or 1


def is_measured(report: Report) -> bool:
    """True if a robot has learnt parameters of the channel."""
    return bool(np.isfinite(report.learnt_level).any() or np.isfinite(report.learnt_reception).any())


def drawable(report: Report) -> Bools:
    """True for each link whose separation is on the axis of a chart [l]; false for an unknown one."""
    known: Bools = (report.separation > _LEAST) & (report.separation < _MOST)
    return known


def separation_range(separation: Floats) -> tuple[float, float]:
    """A range of round separations [m] somewhat wider than the present ones, so that the axis rarely changes.

    >>> separation_range(np.array([61.0, 73.0])), separation_range(np.array([0.4]))
    ((55.0, 80.0), (0.35, 0.45))
    """
    low, high = float(separation.min()), float(separation.max())
    step = 5.0 * 10.0 ** math.floor(math.log10(high / 20.0))
    first, last = max(0, math.floor(low / step) - 1), math.ceil(high / step) + 1
    return float(f"{first * step:.6g}"), float(f"{last * step:.6g}")


def reference_separation(report: Report) -> float:
    """rho_0 [m], from learnt parameters and learnt receptions; NaN if these are unknown."""
    with np.errstate(all="ignore"):
        predictor = np.log(-np.log(report.learnt_reception))
        log_ratio = (predictor - report.learnt_level) / report.learnt_exponent
        scale = report.separation * np.exp(-log_ratio)
    return median(scale[scale > 0.0])


def curves(report: Report, separation: Floats) -> tuple[Floats, Floats]:
    """Reception at each `separation` [k] [m]: of the links' median parameters, and true; NaN where unknown."""
    log_ratio = np.log(np.maximum(separation, _LEAST) / reference_separation(report))
    learnt = median(report.learnt_level), median(report.learnt_exponent)
    return _reception(*learnt, log_ratio), _reception(report.true_level, report.true_exponent, log_ratio)


def median(values: Floats) -> float:
    """Median of the finite values [k]; NaN without one."""
    known = values[np.isfinite(values)]
    with np.errstate(over="ignore"):
        return float(np.median(known)) if len(known) else math.nan


def _reception(level: float, exponent: float, log_ratio: Floats) -> Floats:
    """Reception p where ln(r / rho_0) is `log_ratio` [k]; NaN where the parameters are unknown."""
    with np.errstate(all="ignore"):
        probability: Floats = np.exp(-np.exp(np.clip(level + exponent * log_ratio, -_FLAT, _FLAT)))
    return probability
