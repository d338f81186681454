"""The robots' own half of the performance index (16): the separations that they prefer, radio aside.

Equation (16) is J(r) = S(r) p(r). S is the team's own preference (spread out, but not too far), and robots know it. p
is the reception probability, a property of the channel. The paper writes one nu for the shape of S and for the path
loss inside p. Only two exponents, 4 and 3, give its Fig. 3, so they are kept apart.
"""

import numpy as np

from fes.arrays.types import Floats
from fes.model.config import ObjectiveConfig


def preference(separation: Floats, objective: ObjectiveConfig) -> Floats:
    """S(r) = [1 - exp(-(r/r_min)^s)] exp(-(r/r_x)^s) at `separation` [m], any shape; from (16)."""
    shape = objective.shape_exponent
    ratio = objective.minimum_separation / objective.maximum_separation
    spread = np.power(separation / objective.minimum_separation, shape)
    preference: Floats = -np.expm1(-spread) * np.exp(-(ratio**shape) * spread)
    return preference


def log_preference_slope(separation: Floats, objective: ObjectiveConfig) -> Floats:
    """(ln S)' [1/m] at `separation` [m], any shape; from (16)."""
    shape = objective.shape_exponent
    spread = np.power(separation / objective.minimum_separation, shape)
    reach = np.power(separation / objective.maximum_separation, shape)
    with np.errstate(over="ignore"):  # far beyond r_min the first term is 0, as it should be
        # spread / (e^spread - 1) tends to 1 where the separation is so small that spread underflows
        fall = np.where(spread > 0.0, spread / np.expm1(np.maximum(spread, np.finfo(np.float64).tiny)), 1.0)
        slope: Floats = shape / separation * (fall - reach)
    return slope


def log_preference_curvature(separation: Floats, objective: ObjectiveConfig) -> Floats:
    """(ln S)'' [1/m^2] at `separation` [m], any shape; from (16).

    With A = (r/r_min)^s and f = A/(e^A - 1): r (ln S)' = s (f - (r/r_x)^s), and r f' = s f (1 - A e^A/(e^A - 1)).
    """
    shape = objective.shape_exponent
    spread = np.power(separation / objective.minimum_separation, shape)
    reach = np.power(separation / objective.maximum_separation, shape)
    with np.errstate(over="ignore", invalid="ignore"):
        safe = np.maximum(spread, np.finfo(np.float64).tiny)
        fall = np.where(spread > 0.0, spread / np.expm1(safe), 1.0)
        turn = np.where(spread > 0.0, safe / -np.expm1(-safe), 1.0)
    curvature: Floats = shape / separation**2 * (shape * (fall * (1.0 - turn) - reach) - fall + reach)
    return curvature
