"""Outage of a single-antenna link under Rayleigh fading: equations (3) and (4) in closed form.

This is the formula that the paper's robots are said not to know. The world may use it; of the agents' modules
only `agents.oracle` may import it. `tests/test_architecture.py` holds them to it.
"""

import math

import numpy as np

from fes.arrays import Floats
from fes.config import ChannelConfig


def exponent_scale(channel: ChannelConfig) -> float:
    """c [m^-nu] of the reception probability exp(-c r^nu), from (3): (2^delta - 1) / SNR / r0^nu.

    A perfect channel has c = 0.
    """
    if channel.model == "perfect":
        return 0.0
    threshold = math.exp2(channel.spectral_efficiency) - 1.0
    return float(threshold / channel.reference_snr / channel.reference_distance**channel.path_loss_exponent)


def reception_probability(separation: Floats, channel: ChannelConfig) -> Floats:
    """Probability that a beacon decodes at `separation` [m], any shape: 1 - outage, after (3)."""
    return np.exp(-exponent_scale(channel) * np.power(separation, channel.path_loss_exponent))


def outage_probability(separation: Floats, channel: ChannelConfig) -> Floats:
    """Outage P[C < delta] at `separation` [m], any shape; equation (3)."""
    return -np.expm1(-exponent_scale(channel) * np.power(separation, channel.path_loss_exponent))


def range_at_outage(outage: float, channel: ChannelConfig) -> float:
    """The separation [m] at which the outage is `outage` in (0, 1); equation (4) solved for r.

    Raises ValueError for an outage outside (0, 1), and for a perfect channel, which never reaches it.
    """
    if not 0.0 < outage < 1.0:
        raise ValueError(f"outage must lie in (0, 1): {outage}")
    scale = exponent_scale(channel)
    if scale == 0.0:
        raise ValueError("a perfect channel reaches no outage at any separation")
    return float((-math.log1p(-outage) / scale) ** (1.0 / channel.path_loss_exponent))
