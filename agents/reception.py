"""Measured reception: what a robot learns of the channel by counting beacons; nobody tells it the formula.

Each beacon slot of a link is one Bernoulli sample at the link's separation: decoded or missed. Over a small range
of separations ln(-ln p), p the reception probability, is close to a line in u = ln(r / rho_0), with slope nu (the
exponent) and level alpha. A robot fits that line by iteratively reweighted regression with two memories, a short
one (F) for the level and a long one (S) for the slope, and mixes its sums with those of the robots it hears, so
that the network's links are pooled. What is sought is then (ln J)' = (ln S)' + (ln p)' = 0.

Statistics travel in the Beacon and belong to the robot, so links that come and go lose nothing.
"""

from dataclasses import dataclass

import numpy as np

from agents.contacts import Contacts
from fes import objective
from fes.arrays import Bools, Floats, Ints
from fes.config import ObjectiveConfig
from fes.edges import Edges

SUMS = 5
"""F0, F1, F3 (short memory: weight, weighted u, weighted working response), S11, S1z (long memory: slope)."""

SHORT_MEMORY, LONG_MEMORY = 6.0, 120.0  # s
MIXING = 0.1
"""Share of each heard robot's sums that is mixed in each tick."""

LOW, HIGH = -6.0, 1.5
"""Bounds of the linear predictor ln(-ln p): reception between 0.2 % and 1.1 %."""

LEAST_WEIGHT = 2.0
"""Weight from which on the short memory's means are good enough to correct the slope."""

SLOPE_PRIOR = (0.25, 0.1)
"""Sums that stand for a slope of 2.5 before anything was measured."""

LEVEL_PRIOR = (float(np.log(-np.log(0.9))), 0.1 / 2.25)
"""A reception of 0.9 at rho_0, with the weight that it has."""

SLOPES = (0.5, 8.0)
GAIN, SPEED, LEAST_CURVATURE = 0.3, 5.0, 2e-4
"""Newton's step a second; bound on an estimate's speed [m/s]; curvature that it never falls below [1/m^2]."""

ESTIMATES = (20.0, 145.0)
"""Bounds of an estimate [m]."""


@dataclass(frozen=True, eq=False)
class Reception:
    """What the robots of a crew know of the channel."""

    sums: Floats
    """[n, SUMS]"""
    level: Floats
    """alpha [n]"""
    exponent: Floats
    """nu [n]"""


def nothing(n: int) -> Reception:
    """What robots know before their first beacon."""
    return _fit(np.zeros((n, SUMS)))


def mix(reception: Reception, edges: Edges, heard: Bools, theirs: Floats, dt: float) -> Reception:
    """The sums after a tick's exchange: mixed with `theirs` [m, SUMS] of the peers heard, then aged.

    It comes before the tick's own samples are added: hearing a peer is correlated with its beacon having decoded,
    and mixing afterwards would bias the estimates by a third of a meter.
    """
    count = edges.sum(heard.astype(np.float64))
    share = np.minimum(MIXING, 1.0 / (1.0 + count))
    sums = np.empty_like(reception.sums)
    for column in range(SUMS):
        told = edges.sum(np.where(heard, theirs[:, column], 0.0))
        sums[:, column] = reception.sums[:, column] + share * (told - count * reception.sums[:, column])
    sums[:, :3] *= np.exp(-dt / SHORT_MEMORY)
    sums[:, 3:] *= np.exp(-dt / LONG_MEMORY)
    return Reception(sums, reception.level, reception.exponent)


def learn(reception: Reception, rows: Ints, separation: Floats, decoded: Bools, scale: float) -> Reception:
    """The sums and the fit after beacon slots [s] of robots `rows`, at `separation` [m]; rho_0 is `scale` [m]."""
    n = len(reception.level)
    u = np.log(separation / scale)
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
    sums = before.copy()
    for column, values in enumerate(
        (weight, weight * u, response, counts * weight * centered**2, counts * centered * (response - weight * mean))
    ):
        sums[:, column] += np.bincount(rows, values, minlength=n)
    return _fit(sums)


def slots(before: Contacts, now: Contacts, tick: int, among: Bools) -> tuple[Ints, Floats, Bools]:
    """The beacon slots [s] that each robot has learnt of at this tick: row, separation [m], decoded or missed.

    A miss is learnt from the gap before the next decoded beacon; the separation at the time of the miss is
    interpolated between the decoded beacons on its two sides.
    """
    fresh = np.flatnonzero((now.heard == tick - 1) & among)
    if len(fresh) == 0:
        return fresh, np.zeros(0), np.zeros(0, dtype=np.bool_)
    at = now.edges.places_in(before.edges)[fresh] if now.edges is not before.edges else fresh
    last = np.where(at >= 0, before.heard.take(at, mode="clip"), -1) if len(before.edges) else np.full(len(fresh), -1)
    missed = np.where(last >= 0, tick - 2 - last, 0)
    start = before.heard_separation.take(at, mode="clip") if len(before.edges) else np.zeros(len(fresh))
    end = now.heard_separation[fresh]
    which = np.repeat(np.arange(len(fresh)), missed)
    order = np.arange(len(which)) - np.repeat(np.cumsum(missed) - missed, missed) + 1
    between = start[which] + (end - start)[which] * order / (missed[which] + 1)
    rows = now.edges.rows[fresh]
    decoded = np.concatenate([np.ones(len(fresh), dtype=np.bool_), np.zeros(len(which), dtype=np.bool_)])
    return np.concatenate([rows, rows[which]]), np.concatenate([end, between]), decoded


def drift(reception: Reception, rows: Ints, estimate: Floats, preferred: ObjectiveConfig, scale: float) -> Floats:
    """Speed [l] [m/s] at which estimates [l] [m] of links of robots `rows` climb ln J: a bounded Newton step."""
    exponent = reception.exponent[rows]
    rate = np.exp(reception.level[rows]) * np.power(estimate / scale, exponent)
    channel = -exponent * rate / estimate  # (ln p)'
    slope = objective.log_preference_slope(estimate, preferred) + channel
    curvature = objective.log_preference_curvature(estimate, preferred) + channel * (exponent - 1.0) / estimate
    speed: Floats = np.clip(-GAIN * slope / np.minimum(curvature, -LEAST_CURVATURE), -SPEED, SPEED)
    return speed


def _fit(sums: Floats) -> Reception:
    exponent = np.clip((sums[:, 4] + SLOPE_PRIOR[0]) / (sums[:, 3] + SLOPE_PRIOR[1]), *SLOPES)
    value, weight = LEVEL_PRIOR
    level = np.clip((sums[:, 2] - exponent * sums[:, 1] + weight * value) / (sums[:, 0] + weight), LOW, HIGH)
    return Reception(sums, level, exponent)
