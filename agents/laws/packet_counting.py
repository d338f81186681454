"""Measured reception: what a robot learns of the channel by counting beacons; nobody tells it the formula.

Each beacon slot of a link is one Bernoulli sample at the link's separation: decoded or missed. Over a small range
of separations ln(-ln p), p the reception probability, is close to a line in u = ln(r / rho_0), with slope nu (the
exponent) and level alpha. The line is fitted by iteratively reweighted regression with two memories, a short one (F)
for the level and a long one (S) for the slope. What is sought is then (ln J)' = (ln S)' + (ln p)' = 0.

Who learns is a learner, one row of the arrays. With pooling, learners are robots: each mixes its sums with those of
the robots it hears (they travel in the Beacon), so every link teaches all, and links that come and go lose nothing.
Without, each end of each link is a learner of its own.
"""

from dataclasses import dataclass, replace

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model import objective
from fes.model.config import ObjectiveConfig

SUMS = 5
"""F0, F1, F3 (short memory: weight, weighted u, weighted working response), S11, S1z (long memory: slope)."""


@dataclass(frozen=True)
class Method:
    """How the samples of one learner are weighed."""

    short_memory: float
    """Of the level [s]."""
    long_memory: float
    """Of the slope [s]."""
    slope_prior: tuple[float, float]
    """S1z and S11 that stand for a slope before anything was measured: little, for their ratio is where estimates are
    pulled to. Ten times as much biases them by 0.2 m on a channel whose slope is 5.4 instead of 2.5."""
    slopes: tuple[float, float]
    """Bounds of the slope nu."""
    gain: float
    """Share of Newton's step that is taken in a second."""


POOLED = Method(6.0, 120.0, (0.025, 0.01), (0.5, 8.0), 0.3)
"""Many links teach one learner."""

ALONE = Method(10.0, 30.0, (0.05, 0.02), (-15.0, 20.0), 0.2)
"""One link does. In a shadow its reception may well rise with its length; and what it learnt some meters away tells
little of where it is, so it forgets sooner."""

MIXING = 0.1
"""Share of each heard robot's sums that is mixed in each tick."""

LOW, HIGH = -6.0, 1.5
"""Bounds of the linear predictor ln(-ln p): reception between 99.8 % and 1.1 %."""

NEAREST = 0.1
"""Part of rho_0 below which a separation counts as this: the line is not meant for there."""

LEAST_WEIGHT = 2.0
"""Weight from which on the short memory's means are good enough to correct the slope."""

LEVEL_PRIOR = (float(np.log(-np.log(0.9))), 0.1 / 2.25)
"""A reception of 0.9 at rho_0, with the weight that it has."""

SPEED, LEAST_CURVATURE, ESTIMATES = 5.0, 2e-4, (20.0, 145.0)
"""Bounds on an estimate's speed [m/s], on the curvature [1/m^2] and on an estimate [m], for a team that spreads up to
FARTHEST; others scale them."""

FARTHEST = 150.0
"""[m]"""


@dataclass(frozen=True, eq=False)
class Reception:
    """What learners know of the channel."""

    method: Method
    sums: Floats
    """[g, SUMS]"""
    level: Floats
    """alpha [g]"""
    exponent: Floats
    """nu [g]"""


def no_counts(method: Method, learners: int) -> Reception:
    """What they know before their first beacon."""
    return _fit(method, np.zeros((learners, SUMS)))


def carry(reception: Reception, old: Edges, new: Edges) -> Reception:
    """The learners of the links `new`, where those of `old` were before: new ones know nothing."""
    if new is old:
        return reception
    at, metrics = new.places_in(old), np.zeros((len(new), SUMS))
    metrics[at >= 0] = reception.sums[at[at >= 0]]
    return _fit(reception.method, metrics)


def forget(reception: Reception, who: Bools) -> Reception:
    """The learners `who` [g] know nothing any more."""
    return _fit(reception.method, np.where(who[:, None], 0.0, reception.sums))


def fade(reception: Reception, dt: float) -> Reception:
    """The sums a tick of `dt` [s] older."""
    metrics = reception.sums.copy()
    metrics[:, :3] *= np.exp(-dt / reception.method.short_memory)
    metrics[:, 3:] *= np.exp(-dt / reception.method.long_memory)
    return replace(reception, sums=metrics)


def mix(reception: Reception, edges: Edges, heard: Bools, theirs: Floats) -> Reception:
    """The sums of robots after a tick's exchange: mixed with `theirs` [m, SUMS] of the peers heard.

    It comes before the tick's own samples are added: hearing a peer is correlated with its beacon having decoded,
    and sums mixed afterwards carry that (an rmse of 0.32 m instead of 0.27 over the same ten seeds).
    """
    count = edges.sum(heard.astype(np.float64))
    share = np.minimum(MIXING, 1.0 / (1.0 + count))
    metrics = np.empty_like(reception.sums)
    for column in range(SUMS):
        told = edges.sum(np.where(heard, theirs[:, column], 0.0))
        metrics[:, column] = reception.sums[:, column] + share * (told - count * reception.sums[:, column])
    return replace(reception, sums=metrics)


def learn(reception: Reception, rows: Ints, separation: Floats, decoded: Bools, scale: float) -> Reception:
    """The sums and the fit after beacon slots [s] of learners `rows`, at `separation` [m]; rho_0 is `scale` [m]."""
    n = len(reception.level)
    u = np.log(np.maximum(separation / scale, NEAREST))
    predictor = np.clip(reception.level[rows] + reception.exponent[rows] * u, LOW, HIGH)
    rate = np.exp(predictor)  # -ln p
    p = np.exp(-rate)
    weight = rate * rate * p / (1.0 - p)
    response = weight * predictor + np.where(decoded, -rate, rate * p / (1.0 - p))
    before = reception.sums
    known = before[:, 0] > LEAST_WEIGHT
    safe = np.where(known, before[:, 0], 1.0)
    centered = u - (before[:, 1] / safe)[rows]
    mean = (before[:, 2] / safe)[rows]
    counts = known[rows].astype(np.float64)
    metrics = before.copy()
    for column, values in enumerate(
        (weight, weight * u, response, counts * weight * centered**2, counts * centered * (response - weight * mean))
    ):
        metrics[:, column] += np.bincount(rows, values, minlength=n)
    return _fit(reception.method, metrics)


def drift(reception: Reception, rows: Ints, estimate: Floats, preferred: ObjectiveConfig, scale: float) -> Floats:
    """Speed [l] [m/s] at which estimates [l] [m] of links of learners `rows` climb ln J: a bounded Newton step."""
    exponent = reception.exponent[rows]
    rate = np.exp(reception.level[rows]) * np.power(estimate / scale, exponent)
    channel = -exponent * rate / estimate  # (ln p)'
    slope = objective.log_preference_slope(estimate, preferred) + channel
    curvature = objective.log_preference_curvature(estimate, preferred) + channel * (exponent - 1.0) / estimate
    size = preferred.maximum_separation / FARTHEST
    step = -reception.method.gain * slope / np.minimum(curvature, -LEAST_CURVATURE / np.square(size))
    speed: Floats = np.clip(step, -SPEED * size, SPEED * size)
    return speed


def bounded(estimate: Floats, preferred: ObjectiveConfig) -> Floats:
    """Estimates [l] [m] within what the team can want: the line that was fitted says nothing beyond."""
    size = preferred.maximum_separation / FARTHEST
    inside: Floats = np.clip(estimate, ESTIMATES[0] * size, ESTIMATES[1] * size)
    return inside


def _fit(method: Method, metrics: Floats) -> Reception:
    prior = method.slope_prior
    exponent = np.clip((metrics[:, 4] + prior[0]) / (metrics[:, 3] + prior[1]), *method.slopes)
    value, weight = LEVEL_PRIOR
    level = np.clip((metrics[:, 2] - exponent * metrics[:, 1] + weight * value) / (metrics[:, 0] + weight), LOW, HIGH)
    return Reception(method, metrics, level, exponent)
