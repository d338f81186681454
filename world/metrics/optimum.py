"""r*, the separation that maximizes the performance index (16): the optimum that the robots seek.

r* is computed in decimal arithmetic of 40 digits, whose exponents do not overflow. The result is the float nearest
to the true optimum, for every channel and objective, and equal on every machine.
"""

import decimal
import struct
from decimal import Decimal
from functools import lru_cache

from fes.model.config import FORMULAS, ChannelConfig, ObjectiveConfig
from fes.model.table import chosen

_EXACT = decimal.Context(prec=40, Emax=decimal.MAX_EMAX, Emin=decimal.MIN_EMIN, traps=[])
"""Rounding errors stay 20 digits below those of a float. Without traps, an exp that overflows is infinite."""

_SMALL = Decimal("1e-9")
"""Below this, e^x - 1 is computed as a series, because the difference would lose digits."""


def optimal_separation(objective: ObjectiveConfig, channel: ChannelConfig, quality_weight: float = 1.0) -> float:
    """r* [m], the float nearest to the maximum of (16), for any channel and objective.

    r (ln J)' = s [A/(e^A - 1) - (r/r_x)^s] + r (ln p)' with A = (r/r_min)^s. The first term falls strictly, from
    s > 0 at 0 to below 0 at r_x. The second term is 0 at 0 and never rises: it is -nu c r^nu by (3), and
    -r (1 - p)/width for the logistic channel, both factors of which rise. Hence J has one maximum, between 0 and
    r_x. An optimum below the smallest float is returned as that float.

    With another `quality_weight` beta > 0 it is the best link of a team: the maximum of ln c + beta ln q, where J is
    c q. Its slope is that above with beta on all terms but A/(e^A - 1). A maximum beyond r_x is returned as r_x.
    """
    if channel.model not in FORMULAS:
        raise ValueError(f"only a formula has this optimum, and not channel.model '{chosen(channel.model).use}'")
    # Only the formula counts; shadowing, bursts and jammers are not hashable.
    formula = {name: getattr(channel, name) for name in ChannelConfig.model_fields}
    return _optimum(objective, ChannelConfig.model_construct(**formula), quality_weight)


@lru_cache(maxsize=256)
def _optimum(objective: ObjectiveConfig, channel: ChannelConfig, quality_weight: float) -> float:
    """Bisect the bits of the floats as integers, which have the order of the floats, down to two neighbors."""
    low, high, weight = 0, _bits(objective.maximum_separation), Decimal(quality_weight)
    with decimal.localcontext(_EXACT):
        while high - low > 1:
            middle = (low + high) // 2
            if _rises(Decimal(_float(middle)), objective, channel, weight):
                low = middle
            else:
                high = middle
        between = (Decimal(_float(low)) + Decimal(_float(high))) / 2
        return _float(low if low and not _rises(between, objective, channel, weight) else high)


def _rises(r: Decimal, objective: ObjectiveConfig, channel: ChannelConfig, quality_weight: Decimal) -> bool:
    """True if ln c + beta ln q rises at r [m], that is, if r times its slope, over s, is positive."""
    shape, log = Decimal(objective.shape_exponent), r.ln()
    spread, reach = (
        (shape * (log - _ln(scale))).exp() for scale in (objective.minimum_separation, objective.maximum_separation)
    )
    return spread / _exp_less_one(spread) > quality_weight * (reach + _loss(r, log, channel) / shape)


def _loss(r: Decimal, log: Decimal, channel: ChannelConfig) -> Decimal:
    """-r (ln p)' [1] at r [m]; `log` is ln r."""
    if channel.model == "perfect":
        return Decimal(0)
    if channel.model == "logistic":
        width = Decimal(channel.logistic_width)
        excess = (r - Decimal(channel.logistic_midpoint)) / width
        return r / width / (1 + (-excess).exp())
    exponent = Decimal(channel.path_loss_exponent)
    threshold = _exp_less_one(Decimal(channel.spectral_efficiency) * _ln(2.0))
    power = (exponent * (log - _ln(channel.reference_distance))).exp()
    return exponent * threshold / Decimal(channel.reference_snr) * power


@lru_cache(maxsize=256)
def _ln(value: float) -> Decimal:
    """ln of a setting; every step of the bisection needs it."""
    return _EXACT.ln(Decimal(value))


def _exp_less_one(x: Decimal) -> Decimal:
    """e^x - 1 for x > 0."""
    return x * (1 + x / 2 * (1 + x / 3 * (1 + x / 4))) if x < _SMALL else x.exp() - 1


def _bits(value: float) -> int:
    """Bits of a positive float, as an integer."""
    return int(struct.unpack("<q", struct.pack("<d", value))[0])


def _float(bits: int) -> float:
    """The float with these bits."""
    return float(struct.unpack("<d", struct.pack("<q", bits))[0])
