"""The elementary functions of every law, channel and metric: fixed sequences of IEEE 754 operations.

Only + - * / and sqrt, comparisons, selections, and operations on bits: each of these is rounded in one way by every
processor and every numpy. No table, so that a compiler can compute several values at once. The bits are frozen:
golden digests depend on them.
"""

from fes.arithmetic.angle import atan2
from fes.arithmetic.exponential import exp, exp_and_rise, one_minus_exp
from fes.arithmetic.logarithm import log, log1p, log_sum_exp
from fes.arithmetic.power import power, product, real_power
from fes.arithmetic.trigonometry import sin_cos

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
