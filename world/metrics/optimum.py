"""The separation that maximizes the performance index (16): what the robots are to find.

r* is computed in decimal arithmetic of 40 digits, whose exponents do not overflow. So it is the float nearest to the
true optimum, for every channel and objective, and the same one on every machine.
"""

import decimal
import struct
from decimal import Decimal
from functools import lru_cache

from fes.model.config import ChannelConfig, ObjectiveConfig

_EXACT = decimal.Context(prec=40, Emax=decimal.MAX_EMAX, Emin=decimal.MIN_EMIN, traps=[])
"""Rounding errors stay 20 digits below a float's. No trap: an exp that overflows even this is infinite."""

_SMALL = Decimal("1e-9")
"""Below this, e^x - 1 is summed as a series: the difference would lose digits."""


def optimal_separation(preferred: ObjectiveConfig, channel: ChannelConfig) -> float:
    """r* [m], the float nearest to the maximum of (16), for any channel and objective.

    r (ln J)' = s [A/(e^A - 1) - (r/r_x)^s] + r (ln p)' with A = (r/r_min)^s. Its first part falls strictly, from
    s > 0 at 0 to below 0 at r_x; its second is 0 at 0 and never rises: -nu c r^nu after (3), or -r (1 - p)/width
    of the logistic channel, both factors of which rise. So J has one maximum, between the two. An optimum below the
    smallest float is given as that float.
    """
    # Only the formula of a channel counts; its shadowing, bursts and jammers have no hash.
    formula = {name: getattr(channel, name) for name in ChannelConfig.model_fields}
    return _optimum(preferred, ChannelConfig.model_construct(**formula))


@lru_cache(maxsize=256)
def _optimum(preferred: ObjectiveConfig, channel: ChannelConfig) -> float:
    """Bisect the integers of the floats' bits, which are in the floats' order, until two neighbors are left."""
    low, high = 0, _bits(preferred.maximum_separation)
    with decimal.localcontext(_EXACT):
        while high - low > 1:
            middle = (low + high) // 2
            if _rises(Decimal(_float(middle)), preferred, channel):
                low = middle
            else:
                high = middle
        between = (Decimal(_float(low)) + Decimal(_float(high))) / 2
        return _float(low if low and not _rises(between, preferred, channel) else high)


def _rises(r: Decimal, preferred: ObjectiveConfig, channel: ChannelConfig) -> bool:
    """True if ln J rises at r [m]: the sign of r (ln J)' / s."""
    shape, log = Decimal(preferred.shape_exponent), r.ln()
    spread, reach = (
        (shape * (log - _ln(scale))).exp() for scale in (preferred.minimum_separation, preferred.maximum_separation)
    )
    return spread / _exp_less_one(spread) > reach + _loss(r, log, channel) / shape


def _loss(r: Decimal, log: Decimal, channel: ChannelConfig) -> Decimal:
    """-r (ln p)' [1] at r [m], whose logarithm is `log`."""
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
    """ln of a setting, which every step needs again."""
    return _EXACT.ln(Decimal(value))


def _exp_less_one(x: Decimal) -> Decimal:
    """e^x - 1 for x > 0."""
    return x * (1 + x / 2 * (1 + x / 3 * (1 + x / 4))) if x < _SMALL else x.exp() - 1


def _bits(value: float) -> int:
    """The bits of a positive float as an integer."""
    return int(struct.unpack("<q", struct.pack("<d", value))[0])


def _float(bits: int) -> float:
    """The float of these bits."""
    return float(struct.unpack("<d", struct.pack("<q", bits))[0])
