"""A channel from measurements: maximum likelihood, with 95 % intervals from the observed Fisher information."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from console.fit import likelihood, shares
from console.fit.likelihood import Maximum
from console.fit.measurements import Packets, Powers
from console.fit.shares import NORMAL
from fes.arrays.types import Floats
from fes.errors import FesError
from fes.extension.context import SeededDraws, WorldContext
from fes.model import objective, outage
from fes.model.config import ObjectiveConfig
from world.config.events import changed
from world.config.radio import RadioConfig
from world.metrics.best_separation import best_separation

Interval = tuple[float, float]

LARGEST_EXPONENT = 20.0
WIDTHS = (1e-3, 1e6)
"""Smallest and largest width of a logistic channel [m]."""

OBJECTIVE = ObjectiveConfig()
"""The objective for which r* is computed."""

STEP = 1e-4
"""Steps of differences, relative to r* or to a standard error [1]."""

OTHERWISE = "--model table follows the measured shares"


class Fit(NamedTuple):
    """A channel, and what is known of its fields."""

    settings: dict[str, Any]
    """Fields of the channel, those that were chosen included."""
    intervals: dict[str, Interval]
    """95 % interval of each fitted field; of a table, of the probability of each row, by its number."""
    band: Callable[[Floats], tuple[Floats, Floats, Floats]]
    """Separations [k] [m] -> reception probability, and its 95 % interval at each of them [k]."""
    log_likelihood: float
    optimal: float
    """r* for the default objective [m]."""
    optimal_interval: Interval | None
    """95 % interval of r* [m]; None for a table."""
    spread: float | None = None
    """Standard deviation of the received power / its mean [1]: 1 for Rayleigh fading; None without power."""


def fit(measured: Packets | Powers, model: str, spectral_efficiency: float) -> Fit:
    """The channel of this `model` that makes the measurements most likely; raises FesError where there is none."""
    if isinstance(measured, Powers):
        if model != "rayleigh":
            raise FesError(f"received power has a fit of model 'rayleigh' only, not '{model}'")
        return _rayleigh(measured, spectral_efficiency)
    if model == "table":
        return _table(measured)
    _check_overlap(measured)
    return _logistic(measured) if model == "logistic" else _rayleigh(measured, spectral_efficiency)


def _rayleigh(measured: Packets | Powers, efficiency: float) -> Fit:
    """ln(-ln p) = level + nu ln(r/r0), with r0 the geometric mean of the separations, where both are known best."""
    r0 = float(f"{math.exp(np.log(measured.separation).mean()):.2g}")
    x = np.log(measured.separation / r0)
    spread = None
    if isinstance(measured, Powers):
        power = np.power(10.0, (measured.rssi - measured.threshold) / 10.0)
        # the excess of an exponential variable over a bound has the distribution of the variable
        power -= 1.0 if measured.are_decoded else 0.0
        if not power.any():
            raise FesError(f"no power is above the least that decodes, {measured.threshold:g} dBm")
        maximum = likelihood.maximize(likelihood.faded_power, x, power, -math.log(power.mean()))
        spread = float(np.std(power * np.exp(maximum.predictor(x)[0])))
    else:
        level = math.log(-math.log(measured.decoded.mean()))
        maximum = likelihood.maximize(likelihood.outage, x, measured.decoded.astype(np.float64), level)
    (level, exponent), errors = maximum.parameters, np.sqrt(np.diag(maximum.covariance))
    if not 0.0 < exponent <= LARGEST_EXPONENT:
        raise FesError(f"path_loss_exponent must be from 0 to 20, got {exponent:.4g}: {OTHERWISE}")
    threshold = math.exp2(efficiency) - 1.0

    def settings(parameters: Floats) -> dict[str, Any]:
        return {
            "model": "rayleigh",
            "reference_snr": threshold * math.exp(-parameters[0]),
            "reference_distance": r0,
            "path_loss_exponent": float(parameters[1]),
            "spectral_efficiency": efficiency,
        }

    intervals = {
        "reference_snr": _ordered(*(threshold * math.exp(-level + side * errors[0]) for side in (-NORMAL, NORMAL))),
        "path_loss_exponent": (float(exponent - NORMAL * errors[1]), float(exponent + NORMAL * errors[1])),
    }

    def band(separation: Floats) -> tuple[Floats, Floats, Floats]:
        eta, error = maximum.predictor(np.log(separation / r0))
        value, low, high = (np.exp(-np.exp(eta + side * error)) for side in (0.0, NORMAL, -NORMAL))
        return value, low, high

    return _finished(maximum, settings, intervals, band, spread)


def _logistic(packets: Packets) -> Fit:
    """logit p = level + slope z, in separations z that are centered and scaled."""
    center, scale = float(packets.separation.mean()), float(packets.separation.std())
    z = (packets.separation - center) / scale
    share = float(packets.decoded.mean())
    maximum = likelihood.maximize(
        likelihood.logistic, z, packets.decoded.astype(np.float64), math.log(share / (1 - share))
    )
    level, slope = maximum.parameters
    if slope >= 0.0:
        raise FesError(f"reception does not fall with separation: {OTHERWISE}")
    midpoint, width = center - scale * level / slope, -scale / slope
    if midpoint <= 0.0 or not WIDTHS[0] <= width <= WIDTHS[1]:
        raise FesError(f"logistic_midpoint must be positive, got {midpoint:.4g} m, width {width:.4g} m: {OTHERWISE}")

    def settings(parameters: Floats) -> dict[str, Any]:
        return {
            "model": "logistic",
            "logistic_midpoint": float(center - scale * parameters[0] / parameters[1]),
            "logistic_width": float(-scale / parameters[1]),
        }

    gradient = scale * np.array([-1.0, level / slope]) / slope  # of the midpoint
    half = NORMAL * math.sqrt(float(gradient @ maximum.covariance @ gradient))
    factor = math.exp(NORMAL * math.sqrt(float(maximum.covariance[1, 1])) / -slope)  # of the width: its logarithm
    intervals = {
        "logistic_midpoint": (float(midpoint - half), float(midpoint + half)),
        "logistic_width": (float(width / factor), float(width * factor)),
    }

    def band(separation: Floats) -> tuple[Floats, Floats, Floats]:
        eta, error = maximum.predictor((separation - center) / scale)
        value, low, high = (np.exp(-np.logaddexp(0.0, -eta - side * error)) for side in (0.0, -NORMAL, NORMAL))
        return value, low, high

    return _finished(maximum, settings, intervals, band, None)


def _table(packets: Packets) -> Fit:
    """The measured shares: of all channels with these rows they make the packets of each row most likely."""
    measured = shares.by_separation(packets)
    rows = [
        [round(r, 3), round(p, 6)] for r, p in zip(measured.separation.tolist(), measured.share.tolist(), strict=True)
    ]
    if len(rows) < 2:
        raise FesError("a table needs separations that differ by more than 1 mm")
    intervals = {
        str(row): ends for row, ends in enumerate(zip(measured.low.tolist(), measured.high.tolist(), strict=True))
    }
    share = measured.share.clip(1e-300, 1.0)
    lost = (1.0 - measured.share).clip(1e-300, 1.0)
    value = float((measured.decoded * np.log(share) + (measured.sent - measured.decoded) * np.log(lost)).sum())

    def band(separation: Floats) -> tuple[Floats, Floats, Floats]:
        low, middle, high = (
            np.interp(separation, measured.separation, ends) for ends in (measured.low, measured.share, measured.high)
        )
        return middle, low, high

    settings = {"model": "table", "rows": rows}
    return Fit(settings, intervals, band, value, _optimal(settings), None)


def _finished(
    maximum: Maximum,
    settings: Callable[[Floats], dict[str, Any]],
    intervals: dict[str, Interval],
    band: Callable[[Floats], tuple[Floats, Floats, Floats]],
    spread: float | None,
) -> Fit:
    """The fit, with r* and its interval.

    r* solves (ln S)' + (ln p)' = 0. So its slope by a parameter is that of -(ln p)', over (ln S)'' + (ln p)''. The
    derivatives of (ln p)' are central differences.
    """
    rounded = {name: _rounded(value) for name, value in settings(maximum.parameters).items()}
    optimal = _optimal(rounded)
    around = optimal * np.array([1.0 - STEP, 1.0, 1.0 + STEP])

    def slopes(parameters: Floats) -> Floats:
        """(ln p)' around r* [3]."""
        return outage.log_reception_slope(around, _channel(settings(parameters)))

    steps = np.diag(STEP * np.sqrt(np.diag(maximum.covariance)))
    by_parameter = np.array(
        [
            (slopes(maximum.parameters + step) - slopes(maximum.parameters - step))[1] / (2.0 * step.sum())
            for step in steps
        ]
    )
    before, _, after = slopes(maximum.parameters)
    curvature = float(objective.log_preference_derivatives(around, OBJECTIVE)[1][1]) + (after - before) / (
        around[2] - around[0]
    )
    variance = float(by_parameter @ maximum.covariance @ by_parameter) / curvature**2
    half = NORMAL * math.sqrt(variance)
    return Fit(rounded, intervals, band, maximum.log_likelihood, optimal, (optimal - half, optimal + half), spread)


def _channel(settings: dict[str, Any]) -> RadioConfig:
    """The channel with these fields; raises FesError for those that a scenario refuses."""
    return changed(RadioConfig(), {f"channel.{name}": value for name, value in settings.items()}, 1.0)


def _optimal(settings: dict[str, Any]) -> float:
    """r* of a channel for the default objective [m]."""
    return best_separation(WorldContext(1.0, 2, OBJECTIVE, SeededDraws(0)), _channel(settings))


def _check_overlap(packets: Packets) -> None:
    """Raise FesError where a threshold separates decoded and lost packets: the likelihood then has no maximum."""
    decoded, lost = packets.separation[packets.decoded], packets.separation[~packets.decoded]
    if decoded.max() <= lost.min():
        raise FesError(
            f"every packet up to {decoded.max():g} m decoded and every one from {lost.min():g} m on was lost: "
            "measure separations between, where some are lost"
        )
    if lost.max() <= decoded.min():
        raise FesError(f"reception does not fall with separation: {OTHERWISE}")


def _rounded(value: Any) -> Any:
    """A number with six digits."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def _ordered(first: float, second: float) -> Interval:
    return min(first, second), max(first, second)
