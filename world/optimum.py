"""The separation that maximizes the performance index (16): what the robots are to find."""

import numpy as np

from fes import objective, outage
from fes.arrays import Floats
from fes.config import ChannelConfig, ObjectiveConfig

_BISECTIONS = 60


def log_index_slope(separation: Floats, preferred: ObjectiveConfig, channel: ChannelConfig) -> Floats:
    """(ln J)' [1/m] of (16) at `separation` [m], any shape."""
    wish = objective.log_preference_slope(separation, preferred)
    return wish + outage.log_reception_slope(separation, channel)


def optimal_separation(preferred: ObjectiveConfig, channel: ChannelConfig) -> float:
    """r* [m], the maximum of (16), to machine precision, for any channel and objective.

    r (ln J)' = s [A/(e^A - 1) - (r/r_x)^s] + r (ln p)' with A = (r/r_min)^s. Its first part falls strictly, from
    s > 0 at 0 to below 0 at r_x; its second is 0 at 0 and never rises: -nu c r^nu after (3), or -r (1 - p)/width
    of the logistic channel, both factors of which rise. So J has one maximum, between the two, and bisection
    finds it.
    """
    low, high = 0.0, preferred.maximum_separation
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if log_index_slope(np.float64(middle), preferred, channel) > 0.0:  # type: ignore[arg-type]
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
