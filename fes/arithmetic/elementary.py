"""The elementary functions of every law, channel and metric: fixed sequences of IEEE 754 operations.

Only + - * / and sqrt, comparisons, selections, and operations on bits: each of these is rounded in one way by every
processor and every numpy. No table, so that a compiler can compute several values at once. The bits are frozen:
golden digests depend on them. The compiled core repeats these bits where it was built.
"""

from collections.abc import Callable
from typing import Any

from fes.arithmetic import angle, exponential, logarithm, trigonometry
from fes.arithmetic import power as powers
from fes.arithmetic.core import functions
from fes.errors import FesError


def _loaded() -> functions.Functions | None:
    """The compiled functions, or None. An import cannot report an error of FES_CORE in one line; each run can."""
    try:
        return functions.load()
    except FesError:
        return None


_core = _loaded()

NUMPY: dict[str, Callable[..., Any]] = {
    "atan2": angle.atan2,
    "exp": exponential.exp,
    "exp_and_rise": exponential.exp_and_rise,
    "log": logarithm.log,
    "log1p": logarithm.log1p,
    "log_sum_exp": logarithm.log_sum_exp,
    "one_minus_exp": exponential.one_minus_exp,
    "power": powers.power,
    "product": powers.product,
    "real_power": powers.real_power,
    "sin_cos": trigonometry.sin_cos,
}
"""The definition of each function."""

atan2 = angle.atan2 if _core is None else _core.atan2
exp = exponential.exp if _core is None else _core.exp
exp_and_rise = exponential.exp_and_rise if _core is None else _core.exp_and_rise
log = logarithm.log if _core is None else _core.log
log1p = logarithm.log1p if _core is None else _core.log1p
log_sum_exp = logarithm.log_sum_exp if _core is None else _core.log_sum_exp
one_minus_exp = exponential.one_minus_exp if _core is None else _core.one_minus_exp
power = powers.power if _core is None else _core.power
product = powers.product if _core is None else _core.product
real_power = powers.real_power if _core is None else _core.real_power
sin_cos = trigonometry.sin_cos if _core is None else _core.sin_cos

__all__ = [
    "atan2",
    "exp",
    "exp_and_rise",
    "log",
    "log1p",
    "log_sum_exp",
    "one_minus_exp",
    "power",
    "product",
    "real_power",
    "sin_cos",
]
