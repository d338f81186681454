"""The paper's shortcut (33): the index computed from the channel's formula, which its robots know.

No process of a measured run imports this module.
"""

from typing import Literal

import numpy as np

from agents.laws.perturbation import Index
from agents.laws.seeking_perturbation import PerturbationSeeking
from fes.arrays.types import Floats
from fes.extension.context import LawContext
from fes.model import outage
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig

NEARLY_ZERO = 1e-9
"""The smallest separation [m] at which the index is evaluated: an estimate may overshoot below zero."""

LEAST = -1e9
"""The smallest logarithm of an index; the index itself rounds to zero below exp(-745). Without this bound the slope
would be infinite at an estimate that is far off, because of a peer's estimate of 1e12 m, say."""


def index(objective: ObjectiveConfig, channel: ChannelConfig, transform: Literal["log", "none"]) -> Index:
    """J of (33), or ln J, as a function of separations [m] in an array.

    J(r) = S(r) p(r) = [1 - exp(-A)] exp(-q A - c r^nu), with A = (r/r_min)^s and q = (r_min/r_x)^s. It is evaluated
    at many points per tick, and this form has one exponential less than `fes.model.objective` and `fes.model.outage`.
    For a logistic channel, ln p = -ln(1 + e^z) replaces -c r^nu.
    """
    shape, scale = objective.shape_exponent, objective.minimum_separation
    reach = -((scale / objective.maximum_separation) ** shape)
    logistic = channel.model == "logistic"
    loss = 0.0 if logistic else -outage.exponent_scale(channel)
    exponent = channel.path_loss_exponent

    def exponents(separation: Floats) -> tuple[Floats, Floats]:
        """1 - exp(-A), and -q A + ln p."""
        r = np.maximum(separation, NEARLY_ZERO)
        spread = np.power(r / scale, shape)
        decay = reach * spread
        if loss != 0.0:
            decay += loss * np.power(r, exponent)
        if logistic:
            decay -= np.logaddexp(0.0, outage.logistic_excess(r, channel))
        np.negative(spread, out=spread)
        np.expm1(spread, out=spread)
        return np.negative(spread, out=spread), decay

    def plain(separation: Floats) -> Floats:
        gain, decay = exponents(separation)
        np.exp(decay, out=decay)
        decay *= gain
        return decay

    def log(separation: Floats) -> Floats:
        gain, decay = exponents(separation)
        np.maximum(decay, LEAST, out=decay)
        decay += np.log(gain, out=gain)
        return decay

    return log if transform == "log" else plain


class OracleSeeking(PerturbationSeeking):
    """(18) with the index of the channel's formula."""

    Parameters = OracleConfig
    knows_channel = True

    def __init__(self, parameters: OracleConfig, context: LawContext) -> None:
        assert context.channel is not None
        formula = index(context.objective, context.channel.config, parameters.index_transform)
        super().__init__(parameters, context, formula)
