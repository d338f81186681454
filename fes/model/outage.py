"""Reception and outage of a single-antenna link in closed form: equations (3) and (4), and two that are not Rayleigh.

According to the paper, its robots do not know this formula. The world may use it. Of the agents' modules only
`agents.laws.oracle` may import it, as `tests/architecture/test_architecture.py` checks.
"""

import math
import sys
from functools import lru_cache

import numpy as np

from fes.arithmetic import elementary
from fes.arrays.types import Floats
from fes.model.config import ChannelConfig

_LN2 = np.array(0.6931471805599453)


def exponent_scale(channel: ChannelConfig) -> float:
    """c [m^-nu] of the reception probability exp(-c r^nu), from (3): (2^delta - 1) / SNR / r0^nu.

    c is 0 for a perfect channel, and at most what a float can hold. Raises ValueError for a logistic channel, which
    has no c.
    """
    if channel.model == "logistic":
        raise ValueError("a logistic channel is not of the form exp(-c r^nu)")
    if channel.model == "perfect":
        return 0.0
    threshold = _snr_threshold(channel.spectral_efficiency)
    scale = threshold / channel.reference_snr / _loss(channel.reference_distance, channel.path_loss_exponent)
    return scale if scale < math.inf else sys.float_info.max


def logistic_excess(separation: Floats, channel: ChannelConfig) -> Floats:
    """z [1] of the logistic reception probability 1 / (1 + e^z) at `separation` [m], any shape."""
    excess: Floats = (separation - channel.logistic_midpoint) / channel.logistic_width
    return excess


def reception_probability(separation: Floats, channel: ChannelConfig) -> Floats:
    """Probability that a beacon decodes at `separation` [m], any shape: 1 - outage, by (3) for a Rayleigh channel."""
    if channel.model == "logistic":
        return _logistic(-logistic_excess(separation, channel))
    return elementary.exp(_log_reception(separation, channel))


def outage_probability(separation: Floats, channel: ChannelConfig) -> Floats:
    """Outage probability at `separation` [m], any shape; P[C < delta] of (3) for a Rayleigh channel."""
    if channel.model == "logistic":
        return _logistic(logistic_excess(separation, channel))
    return elementary.one_minus_exp(-_log_reception(separation, channel))


def log_reception_slope(separation: Floats, channel: ChannelConfig) -> Floats:
    """(ln p)' [1/m] of the reception probability p at `separation` [m], any shape.

    -nu c r^(nu - 1) for (3), -(1 - p)/width for the logistic channel.
    """
    if channel.model == "logistic":
        return -outage_probability(separation, channel) / channel.logistic_width
    exponent = channel.path_loss_exponent
    return -(exponent * exponent_scale(channel) * elementary.power(separation, exponent - 1.0))


def range_at_outage(outage: float, channel: ChannelConfig) -> float:
    """The separation [m] with outage probability `outage` in (0, 1); equation (4) solved for r if Rayleigh.

    Raises ValueError for an outage outside (0, 1), and for one that no positive separation has. A perfect channel has
    none of them, a logistic channel none below its outage at separation 0.
    """
    if not 0.0 < outage < 1.0:
        raise ValueError(f"outage must lie in (0, 1): {outage}")
    if channel.model == "logistic":
        odds = np.array(outage / (1.0 - outage))
        separation = channel.logistic_midpoint + channel.logistic_width * float(elementary.log(odds))
        if separation <= 0.0:
            raise ValueError(f"this logistic channel has a larger outage at every separation: {outage}")
        return separation
    scale = exponent_scale(channel)
    if scale == 0.0:
        raise ValueError("a perfect channel reaches no outage at any separation")
    exponent = -elementary.log1p(np.array(-outage))
    return float(elementary.power(exponent / scale, 1.0 / channel.path_loss_exponent))


@lru_cache(maxsize=128)
def _snr_threshold(efficiency: float) -> float:
    """2^delta - 1 of (3), with all its digits where delta is small."""
    if efficiency >= 1.0:
        return float(elementary.power(np.array(2.0), efficiency)) - 1.0
    return float(elementary.exp(_LN2 * efficiency) * elementary.one_minus_exp(_LN2 * efficiency))


@lru_cache(maxsize=128)
def _loss(distance: float, exponent: float) -> float:
    """r0^nu of (3)."""
    return float(elementary.power(np.array(distance), exponent))


def _log_reception(separation: Floats, channel: ChannelConfig) -> Floats:
    """ln p = -c r^nu of (3) at `separation` [m], any shape; infinite beyond what a float can hold."""
    scale = exponent_scale(channel)
    return -scale * elementary.power(separation, channel.path_loss_exponent) if scale else np.zeros_like(separation)


def _logistic(z: Floats) -> Floats:
    """1 / (1 + e^-z), to relative precision at both ends and without overflow."""
    decay = elementary.exp(-np.abs(z))
    result: Floats = np.where(z >= 0.0, 1.0, decay) / (1.0 + decay)
    return result
