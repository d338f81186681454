"""r* of any channel: exactly for a formula, by search for every other channel that depends on separation."""

import math
from collections.abc import Callable

import numpy as np

from fes.arithmetic import elementary
from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from fes.model import objective
from fes.model.config import FORMULAS
from world.config.radio import RadioConfig
from world.metrics.optimum import optimal_separation
from world.metrics.team.delivery import link_quality
from world.simulation import reception

POINTS = 4001
"""Points of the first search: two maxima closer than 1/4000 of the maximum separation may be confused."""

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def best_separation(context: WorldContext, channel: RadioConfig, quality_weight: float = 1.0) -> float:
    """r* [m]: the separation that maximizes J(r) = S(r) p(r).

    NaN for a channel known by pair, not by separation, and for one in which J is 0 everywhere. Of equal maxima the
    nearest counts. With another `quality_weight` beta, it is the best link of a team: the maximum of c q^beta.
    """
    if channel.model in FORMULAS:
        return optimal_separation(context.objective, channel, quality_weight)
    model = reception.model(channel, context)
    if not hasattr(model, "probability"):
        return math.nan
    farthest = context.objective.maximum_separation

    def index(separation: Floats) -> Floats:
        reception: Floats = model.probability(separation)
        if quality_weight == 1.0:  # the digits of r* are those of J itself
            return objective.preference(separation, context.objective) * reception
        quality = link_quality(separation, reception, context.objective)
        weighted = np.where(quality > 0.0, elementary.power(quality, quality_weight), 0.0)
        values: Floats = objective.coverage(separation, context.objective) * weighted
        return values

    grid = np.linspace(farthest / (POINTS - 1), farthest, POINTS - 1)
    values = index(grid)
    best = int(np.argmax(values))
    if not values[best] > 0.0:
        return math.nan
    low, high = float(grid[max(0, best - 1)]), float(grid[min(len(grid) - 1, best + 1)])
    refined = _golden(lambda r: float(index(np.array([r]))[0]), low, high)
    return refined if index(np.array([refined]))[0] >= values[best] else float(grid[best])


def _golden(value: Callable[[float], float], low: float, high: float) -> float:
    """Place of the maximum between `low` and `high`, by golden section: it needs no slope."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    left_value, right_value = value(left), value(right)
    while high - low > 1e-9 * high:
        if left_value >= right_value:
            high, right, right_value = right, left, left_value
            left = high - GOLDEN * (high - low)
            left_value = value(left)
        else:
            low, left, left_value = left, right, right_value
            right = low + GOLDEN * (high - low)
            right_value = value(right)
    return 0.5 * (low + high)
