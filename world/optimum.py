"""The separation that maximizes the performance index (16): what the robots are to find."""

import numpy as np

from fes import objective, outage
from fes.arrays import Floats
from fes.config import ChannelConfig, ObjectiveConfig

_BISECTIONS = 60


def log_index_slope(separation: Floats, preferred: ObjectiveConfig, channel: ChannelConfig) -> Floats:
    """(ln J)' [1/m] of (16) at `separation` [m], any shape."""
    exponent = channel.path_loss_exponent
    loss = exponent * outage.exponent_scale(channel) * np.power(separation, exponent - 1.0)
    return objective.log_preference_slope(separation, preferred) - loss


def optimal_separation(preferred: ObjectiveConfig, channel: ChannelConfig) -> float:
    """r* [m], the maximum of (16), to machine precision, for any channel and objective.

    r (ln J)' = s [A/(e^A - 1) - (r/r_x)^s] - nu c r^nu with A = (r/r_min)^s falls strictly, from s > 0 at 0
    to below 0 at r_x. So J has one maximum, between the two, and bisection finds it.
    """
    low, high = 0.0, preferred.maximum_separation
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if log_index_slope(np.float64(middle), preferred, channel) > 0.0:  # type: ignore[arg-type]
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
