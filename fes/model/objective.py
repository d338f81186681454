"""The robots' own half of the performance index (16): the separations that they prefer, radio aside.

Equation (16) is J(r) = S(r) p(r). S is the team's own preference (spread out, but not too far), and robots know it. p
is the reception probability, a property of the channel. The paper writes one nu for the shape of S and for the path
loss inside p. Only two exponents, 4 and 3, give its Fig. 3, so they are kept apart.
"""

from functools import lru_cache

import numpy as np

from fes.arithmetic import elementary
from fes.arrays.types import Floats
from fes.model.config import ObjectiveConfig

_TINY, _LARGE = 1e-300, 700.0


def preference(separation: Floats, objective: ObjectiveConfig) -> Floats:
    """S(r) = [1 - exp(-(r/r_min)^s)] exp(-(r/r_x)^s) at `separation` [m], any shape; from (16)."""
    spread = elementary.power(separation / objective.minimum_separation, objective.shape_exponent)
    preference: Floats = elementary.one_minus_exp(spread) * elementary.exp(-share_of_reach(objective) * spread)
    return preference


def coverage(separation: Floats, objective: ObjectiveConfig) -> Floats:
    """c(r) = 1 - exp(-(r/r_min)^s) at `separation` [m], any shape: the factor of (16) that rises with it."""
    spread = elementary.power(separation / objective.minimum_separation, objective.shape_exponent)
    return elementary.one_minus_exp(spread)


def share_of_reach(objective: ObjectiveConfig) -> float:
    """(r_min/r_x)^s, by which the exponent of the second factor of (16) follows from that of the first."""
    return _power(objective.minimum_separation / objective.maximum_separation, objective.shape_exponent)


@lru_cache(maxsize=128)
def _power(ratio: float, exponent: float) -> float:
    return float(elementary.power(np.array(ratio), exponent))


def log_preference_slope(separation: Floats, objective: ObjectiveConfig) -> Floats:
    """(ln S)' [1/m] at `separation` [m], any shape; from (16)."""
    return log_preference_derivatives(separation, objective)[0]


def log_preference_derivatives(
    separation: Floats, objective: ObjectiveConfig, reach_weight: Floats | None = None
) -> tuple[Floats, Floats]:
    """(ln S)' [1/m] and (ln S)'' [1/m^2] at `separation` [m], any shape; from (16).

    `reach_weight` [same shape] is the exponent of the second factor of S, which falls with r; 1 by default.

    With A = (r/r_min)^s and f = A/(e^A - 1): r (ln S)' = s (f - (r/r_x)^s), and r f' = s f (1 - A e^A/(e^A - 1)).
    """
    shape = objective.shape_exponent
    spread = elementary.power(separation / objective.minimum_separation, shape)
    reach = share_of_reach(objective) * spread
    if reach_weight is not None:
        reach = reach_weight * reach
    # A/(e^A - 1) is 1 where A is 0, and 0 where A is large
    bounded = np.minimum(np.maximum(spread, _TINY), _LARGE)
    decay, rise = elementary.exp_and_rise(-bounded, bounded)
    turn = bounded / rise
    fall = turn * decay
    slope: Floats = shape / separation * (fall - reach)
    curvature: Floats = shape / (separation * separation) * (shape * (fall * (1.0 - turn) - reach) - fall + reach)
    return slope, curvature
