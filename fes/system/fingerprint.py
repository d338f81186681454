"""Fingerprint of the arithmetic: a hash of the results of the elementary functions.

Every digit of a run comes from these functions and from operations that IEEE 754 rounds in one way. So the
fingerprint is the same on every processor and with every numpy. It changes only with a version of fes that has
other elementary functions. The version of numpy is recorded, and never compared.
"""

import hashlib
from collections.abc import Iterator, Mapping
from functools import cache

import numpy as np

from fes.arithmetic import elementary, logarithm
from fes.arithmetic.core import functions, library
from fes.arrays.types import Floats

EXPECTED = "171eaa011704"
"""The fingerprint of every machine. It changes only with an elementary function, and so with all digests."""

_EVENLY = 1_500
"""Number of samples over the usual range; the others are at the ends of the ranges and near 0 and 1."""

_EXPONENTS = (0.5, 2.0, 3.0, 3.5, 8.0, 15.5, 1.7, -0.5, -3.3)
"""Products, products with a root, and real powers."""

_LONGEST = 40  # characters

Arithmetic = Mapping[str, str]
"""`fingerprint`, `numpy` (its version) and `core`, as in a summary."""


def table() -> dict[str, str]:
    """The arithmetic of this process. Its core computes the elementary functions: every core gives the same bits."""
    core = library.NUMPY if functions.load() is None else library.C
    return {"fingerprint": _own(), "numpy": np.__version__, "core": core}


def text(arithmetic: Arithmetic | None = None) -> str:
    """The part of an arithmetic that is compared, by default that of this process.

    Processes of one version of fes with equal texts give equal digits.

    Raises KeyError, TypeError or ValueError for anything that is not an arithmetic.

    >>> text({"fingerprint": "5c62e091b8c0", "numpy": "2.4.6", "core": "numpy"})
    'arithmetic 5c62e091b8c0'
    """
    parts = table() if arithmetic is None else arithmetic
    if not all(_is_short(parts[key]) for key in ("fingerprint", "numpy", "core")):
        raise ValueError("an arithmetic is a fingerprint, a version of numpy and a core")
    return f"arithmetic {parts['fingerprint']}"


def origin(version: object, arithmetic: Arithmetic | None = None) -> str:
    """The version of fes, if it is known, and the arithmetic: by default that of this process.

    Raises as `text` does.

    >>> origin("0.4.0", {"fingerprint": "5c62e091b8c0", "numpy": "2.4.6", "core": "numpy"})
    'fes 0.4.0 with arithmetic 5c62e091b8c0'
    """
    return (f"fes {version} with " if _is_short(version) else "") + text(arithmetic)


def compute() -> str:
    """The fingerprint, computed anew."""
    digest = hashlib.sha256()
    with np.errstate(all="ignore"):  # some samples overflow
        for result in _results():
            digest.update(result.astype("<f8", order="C", copy=False).tobytes())
    return digest.hexdigest()[:12]


@cache
def _own() -> str:
    return compute()


def _is_short(part: object) -> bool:
    return isinstance(part, str) and len(part) <= _LONGEST and part.isprintable()


def _results() -> Iterator[Floats]:
    """Results of every elementary function over samples that are exact."""
    positive, fraction = _samples()
    signed = np.concatenate([positive, -positive])
    turned = positive[::-1]
    yield elementary.exp(signed)
    yield elementary.one_minus_exp(positive)
    yield from elementary.exp_and_rise(-positive, turned)
    yield elementary.log(positive)
    yield from (elementary.log1p(positive), elementary.log1p(-fraction))
    yield elementary.log_sum_exp(signed)
    yield elementary.atan2(signed, np.concatenate([turned, turned]))
    yield elementary.atan2(positive, -turned)
    yield from elementary.sin_cos(signed)
    for exponent in _EXPONENTS:
        yield elementary.power(positive, exponent)
    yield elementary.product(positive, 6)
    yield elementary.real_power(np.maximum(fraction, logarithm.SMALLEST), 16.0 * fraction[::-1] - 8.0)


def _samples() -> tuple[Floats, Floats]:
    """Numbers >= 0, and as many from 0 to below 1; all are exact."""
    numbers = np.arange(_EVENLY)
    fraction = (numbers * 2_654_435_761 % 2**32 + 0.5) / 2**32  # as evenly as the golden ratio can
    usual = np.ldexp(fraction, numbers % 41 - 30)  # from 1e-19 to 1024
    steps = np.arange(64)
    near_one = np.concatenate([1.0 - np.ldexp(1.0, -1 - steps[:53]), 1.0 + np.ldexp(1.0, -steps[:53])])
    subnormal = np.ldexp(1.0 + steps, -1074 + steps % 40)
    scales = np.ldexp(1.0 + steps / 64.0, 32 * steps - 1010)  # from 1e-304 to 1e303
    extremes = 680.0 + 1.25 * steps  # e^x overflows, and e^-x underflows
    quarters = 1.5707963267948966 * np.concatenate([1.0 + steps, [263205.0, 526410.0]])  # near zeros of sin, cos
    positive = np.concatenate([[0.0], usual, near_one, subnormal, scales, extremes, quarters])
    count = np.arange(len(positive))
    return positive, (count * 2_654_435_761 % 2**32) / 2**32
