"""The maximum of a concave log-likelihood in level and slope, by Newton's method.

Each observation y at x has the log-likelihood l(eta, y) with eta = level + slope x. The covariance of the two is the
inverse of the observed Fisher information, the negative curvature at the maximum.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Floats
from fes.errors import FesError

STEPS = 200
"""Largest number of Newton's steps."""

HALVINGS = 60
"""Largest number of halvings of a step that does not rise."""

CONVERGED = 1e-12
"""Rise of the log-likelihood that a step promises, relative to it, at which that step is the last one [1]."""

_LARGEST = 700.0  # eta; e^eta stays finite


class Terms(NamedTuple):
    """The log-likelihood of each observation, and its derivatives by eta [k]."""

    value: Floats
    slope: Floats
    curvature: Floats


Family = Callable[[Floats, Floats], Terms]
"""(eta [k], y [k]) -> terms."""


class Maximum(NamedTuple):
    """The maximum of a likelihood."""

    parameters: Floats
    """Level and slope [2]."""
    covariance: Floats
    """[2, 2]"""
    log_likelihood: float

    def predictor(self, x: Floats) -> tuple[Floats, Floats]:
        """eta and its standard error at x [k]."""
        design = np.column_stack([np.ones_like(x), x])
        eta: Floats = design @ self.parameters
        error: Floats = np.sqrt(np.einsum("ki,ij,kj->k", design, self.covariance, design))
        return eta, error


@np.errstate(over="ignore", divide="ignore", invalid="ignore")  # a step may go too far; it is then halved
def maximize(family: Family, x: Floats, y: Floats, level: float) -> Maximum:
    """The maximum of the sum over all observations (x, y) [k], sought from (level, 0).

    Raises FesError where there is none at finite parameters.
    """
    design: Floats = np.column_stack([np.ones_like(x), x])
    parameters: Floats = np.array([level, 0.0])
    terms = family(design @ parameters, y)
    for _ in range(STEPS):
        gradient = design.T @ terms.slope
        information = -(design.T * terms.curvature) @ design
        try:
            covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
        except np.linalg.LinAlgError:
            break
        step = covariance @ gradient
        rise = 0.5 * float(gradient @ step)
        if not np.isfinite(rise):
            break
        before = float(terms.value.sum())
        tolerance = CONVERGED * max(1.0, abs(before))
        if rise <= tolerance:
            return Maximum(parameters + step, covariance, before)
        for _ in range(HALVINGS):
            after = family(design @ (parameters + step), y)
            if after.value.sum() >= before - tolerance:
                break
            step = 0.5 * step
        parameters, terms = parameters + step, after
    raise FesError("the likelihood has no maximum at finite parameters")


def outage(eta: Floats, decoded: Floats) -> Terms:
    """A packet that decodes with probability exp(-e^eta), as by (3) with eta = ln(c r^nu)."""
    rate = np.exp(eta.clip(-_LARGEST, _LARGEST))
    lost = rate * np.exp(-rate) / -np.expm1(-rate)
    return Terms(
        np.where(decoded, -rate, np.log(-np.expm1(-rate))),
        np.where(decoded, -rate, lost),
        np.where(decoded, -rate, lost * (1.0 + rate / np.expm1(-rate))),
    )


def logistic(eta: Floats, decoded: Floats) -> Terms:
    """A packet that decodes with probability 1 / (1 + e^-eta)."""
    probability = np.exp(-np.logaddexp(0.0, -eta))
    return Terms(
        -np.logaddexp(0.0, np.where(decoded, -eta, eta)),
        decoded - probability,
        -probability * np.exp(-np.logaddexp(0.0, eta)),
    )


def faded_power(eta: Floats, power: Floats) -> Terms:
    """A power of exponential distribution with mean e^-eta: Rayleigh fading."""
    ratio = power * np.exp(eta.clip(-_LARGEST, _LARGEST))
    return Terms(eta - ratio, 1.0 - ratio, -ratio)
