"""The paper's shortcut (33): the index computed from the channel's formula, which its robots are told.

No process of a measured run imports this module.
"""

from collections.abc import Callable

import numpy as np

from fes import outage
from fes.arrays import Floats
from fes.config import ChannelConfig, ObjectiveConfig

NEARLY_ZERO = 1e-9
"""The smallest separation [m] at which the index is evaluated: an estimate may be thrown below zero."""


def performance_index(objective_config: ObjectiveConfig, channel: ChannelConfig) -> Callable[[Floats], Floats]:
    """J of (33), as a function of separations [m] in an array: S(r) times the reception probability."""
    shape = objective_config.shape_exponent
    scale = objective_config.minimum_separation
    spread_reach = -((scale / objective_config.maximum_separation) ** shape)
    loss, exponent = -outage.exponent_scale(channel), channel.path_loss_exponent

    def index(separation: Floats) -> Floats:
        # preference() times reception_probability() with one exponential less: eight of these a tick.
        r = np.maximum(separation, NEARLY_ZERO)
        spread = np.power(r / scale, shape)
        decay = np.power(r, exponent)
        decay *= loss
        decay += spread_reach * spread
        np.exp(decay, out=decay)
        np.negative(spread, out=spread)
        np.expm1(spread, out=spread)
        decay *= spread
        return np.negative(decay, out=decay)

    return index
