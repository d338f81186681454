"""Measured reception: a robot's fit of the channel from counted beacons, without its formula.

Each beacon slot of a link is one Bernoulli sample at the link's separation: decoded or missed. With reception
probability p, ln(-ln p) is close to a line in u = ln(r / rho_0) over a small range of separations. The slope of the
line is nu (the exponent), and its level is alpha. It is fitted by iteratively reweighted regression with two
memories, a short one (F) for the level and a long one (S) for the slope. The law then seeks
(ln J)' = (ln S)' + (ln p)' = 0.

A *learner* is one row of the arrays: a robot with pooling, a link end without. With pooling, each robot mixes its
statistics with those of the robots it hears, which travel in the Beacon. So all robots learn from every link, and
a link that ends loses nothing.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fes.arithmetic import elementary
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model import objective
from fes.model.config import ObjectiveConfig

STATISTICS = 5
"""F0, F1, F3 (short memory: weight, weighted u, weighted working response), S11, S1z (long memory: slope)."""


@dataclass(frozen=True)
class Method:
    """The memory, the priors and the gain of a learner."""

    short_memory: float
    """Of the level [s]."""
    long_memory: float
    """Of the slope [s]."""
    slope_prior: tuple[float, float]
    """S1z and S11 of the slope before any sample: small, since they bias estimates towards their ratio, 2.5. Ten
    times as much would bias estimates by 0.2 m on a channel whose slope is 5.4."""
    slopes: tuple[float, float]
    """Bounds of the slope nu."""
    gain: float
    """Share of Newton's step that is taken per second [1/s]."""


POOLED = Method(6.0, 120.0, (0.025, 0.01), (0.5, 8.0), 0.3)
"""For a learner with the samples of many links."""

ALONE = Method(10.0, 30.0, (0.05, 0.02), (-15.0, 20.0), 0.2)
"""For a learner of one link. In a shadow its reception may rise with its length. Samples from some meters away say
little about the link's present place, so the memory of the slope is shorter."""

MIXING = 0.1
"""Share of each heard robot's statistics that is mixed in per tick."""

LOW, HIGH = -6.0, 1.5
"""Bounds of the linear predictor ln(-ln p): reception between 99.8 % and 1.1 %."""

NEAREST = 0.1
"""Smallest separation that is distinguished, in units of rho_0: the line is not meant for shorter links."""

LEAST_WEIGHT = 2.0
"""Smallest weight of the short memory at which its means are good enough to correct the slope."""

LEVEL_PRIOR = (-2.2503673273124454, 0.1 / 2.25)  # ln(-ln 0.9)
"""A reception of 0.9 at rho_0, and its weight."""

SPEED, LEAST_CURVATURE, ESTIMATES = 5.0, 2e-4, (20.0, 145.0)
"""Bounds on an estimate's speed [m/s], on the curvature [1/m^2] and on an estimate [m]. They are for a team whose
maximum separation is FARTHEST, and scale with that separation."""

FARTHEST = 150.0
"""Maximum separation to which these bounds belong [m]."""


@dataclass(frozen=True, eq=False)
class ReceptionFit:
    """The samples of the learners, and the fit to them."""

    method: Method
    statistics: Floats
    """[g, STATISTICS]"""
    level: Floats
    """alpha [g]"""
    exponent: Floats
    """nu [g]"""


def no_counts(method: Method, learners: int) -> ReceptionFit:
    """The fit of learners that have counted no beacon: the prior."""
    return _fit(method, np.zeros((learners, STATISTICS)))


def carry(reception: ReceptionFit, old: Edges, new: Edges) -> ReceptionFit:
    """The learners of the links `new`, from those of the links `old`; a new link has counted no beacon."""
    if new is old:
        return reception
    return _fit(reception.method, new.carry(reception.statistics, old, 0.0))


def forget(reception: ReceptionFit, restarted: Bools) -> ReceptionFit:
    """The learners, with those `restarted` [g] reset to the prior."""
    return _fit(reception.method, np.where(restarted[:, None], 0.0, reception.statistics))


def fade(reception: ReceptionFit, dt: float) -> ReceptionFit:
    """The learners, with their statistics faded by a tick of `dt` [s]."""
    statistics = reception.statistics.copy()
    short, long = shares(reception.method, dt)
    statistics[:, :3] *= short
    statistics[:, 3:] *= long
    return replace(reception, statistics=statistics)


@cache
def shares(method: Method, dt: float) -> tuple[float, float]:
    """Shares of the statistics that remain after a tick of `dt` [s]: short memory, long memory."""
    short, long = elementary.exp(-dt / np.array([method.short_memory, method.long_memory])).tolist()
    return short, long


def mix(reception: ReceptionFit, edges: Edges, heard: Bools, received: Floats) -> ReceptionFit:
    """The statistics of robots after a tick's exchange: mixed with those `received` [m, STATISTICS] of peers `heard`.

    The exchange comes before the tick's own samples, because hearing a peer means that its beacon decoded. Statistics
    mixed afterwards carry that bias: over the same ten seeds an rmse of 0.32 m instead of 0.27 m.
    """
    count = edges.sum(heard.astype(np.float64))
    share = np.minimum(MIXING, 1.0 / (1.0 + count))
    own = reception.statistics
    mixed = np.empty_like(own)
    for column in range(STATISTICS):
        total = edges.sum(np.where(heard, received[:, column], 0.0))
        mixed[:, column] = own[:, column] + share * (total - count * own[:, column])
    return replace(reception, statistics=mixed)


def learn(reception: ReceptionFit, rows: Ints, separation: Floats, decoded: Bools, scale: float) -> ReceptionFit:
    """Statistics and fit after beacon slots [s] of the learners `rows`, at `separation` [m]; rho_0 is `scale` [m]."""
    n = len(reception.level)
    u = elementary.log(np.maximum(separation / scale, NEAREST))
    predictor = np.clip(reception.level[rows] + reception.exponent[rows] * u, LOW, HIGH)
    rate = elementary.exp(predictor)  # -ln p
    p, lost = elementary.exp_and_rise(-rate, rate)
    odds = p / lost
    weight = rate * rate * odds
    response = weight * predictor + np.where(decoded, -rate, rate * odds)
    before = reception.statistics
    known = before[:, 0] > LEAST_WEIGHT
    safe = np.where(known, before[:, 0], 1.0)
    centered = u - (before[:, 1] / safe)[rows]
    mean = (before[:, 2] / safe)[rows]
    counts = known[rows].astype(np.float64)
    statistics = before.copy()
    for column, values in enumerate(
        (
            weight,
            weight * u,
            response,
            counts * weight * (centered * centered),
            counts * centered * (response - weight * mean),
        )
    ):
        statistics[:, column] += np.bincount(rows, values, minlength=n)
    return _fit(reception.method, statistics)


def drift(
    reception: ReceptionFit,
    rows: Ints,
    estimate: Floats,
    config: ObjectiveConfig,
    scale: float,
    quality_weight: Floats | None = None,
) -> Floats:
    """Speed [l] [m/s] at which estimates [l] [m] of links of learners `rows` climb ln J: a bounded Newton step.

    With `quality_weight` beta [l] they climb ln c + beta ln q, where J = c q: c is the factor of (16) that rises with
    the separation.
    """
    exponent = reception.exponent[rows]
    rate = elementary.exp(reception.level[rows] + exponent * elementary.log(estimate / scale))
    channel = -exponent * rate / estimate  # (ln p)'
    if quality_weight is not None:
        channel = quality_weight * channel
    slope, curvature = objective.log_preference_derivatives(estimate, config, quality_weight)
    slope = slope + channel
    curvature = curvature + channel * (exponent - 1.0) / estimate
    size = config.maximum_separation / FARTHEST
    step = -reception.method.gain * slope / np.minimum(curvature, -LEAST_CURVATURE / np.square(size))
    speed: Floats = np.clip(step, -SPEED * size, SPEED * size)
    return speed


def bounded(estimate: Floats, config: ObjectiveConfig) -> Floats:
    """Estimates [l] [m], clipped to ESTIMATES for this team: beyond them the fitted line does not hold."""
    size = config.maximum_separation / FARTHEST
    inside: Floats = np.clip(estimate, ESTIMATES[0] * size, ESTIMATES[1] * size)
    return inside


def _fit(method: Method, statistics: Floats) -> ReceptionFit:
    """The level and the exponent that fit the statistics [g, STATISTICS] and the priors best."""
    prior = method.slope_prior
    exponent = np.clip((statistics[:, 4] + prior[0]) / (statistics[:, 3] + prior[1]), *method.slopes)
    value, weight = LEVEL_PRIOR
    level = np.clip(
        (statistics[:, 2] - exponent * statistics[:, 1] + weight * value) / (statistics[:, 0] + weight), LOW, HIGH
    )
    return ReceptionFit(method, statistics, level, exponent)
