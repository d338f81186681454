"""Fingerprint of the arithmetic: other processors and libraries round some results differently.

numpy, the C library and the linear algebra pick their code by the processor. Two machines with the same
fingerprint and the same version of numpy give the same digits, as far as a sample can show.
"""

import hashlib
import math
from collections.abc import Iterator, Mapping
from functools import cache

import numpy as np

from fes.arrays.types import Floats

CORE = "numpy"
"""The implementation that computes a run."""

_SAMPLES = 16_411
"""A prime, so that vectorized loops leave a remainder. Fewer samples do not tell the C library's variants apart."""

_SCALARS = 1_000
_LONGEST = 40  # characters

Arithmetic = Mapping[str, str]
"""`fingerprint`, `numpy` (its version) and `core`, as in a summary."""


def table() -> dict[str, str]:
    """The arithmetic of this process."""
    return {"fingerprint": _fingerprint(), "numpy": np.__version__, "core": CORE}


def text(arithmetic: Arithmetic | None = None) -> str:
    """An arithmetic in a few words, by default that of this process; equal texts mean equal digits.

    Raises KeyError, TypeError or ValueError for anything that is not an arithmetic.

    >>> text({"fingerprint": "5c62e091b8c0", "numpy": "2.4.6", "core": "numpy"})
    'numpy 2.4.6, arithmetic 5c62e091b8c0'
    """
    parts = table() if arithmetic is None else arithmetic
    numpy, result, core = (parts[key] for key in ("numpy", "fingerprint", "core"))
    if not all(
        isinstance(part, str) and len(part) <= _LONGEST and part.isprintable() for part in (numpy, result, core)
    ):
        raise ValueError("an arithmetic is a fingerprint, a version of numpy and a core")
    return f"numpy {numpy}, arithmetic {result}" + ("" if core == "numpy" else f" ({core})")


@cache
def _fingerprint() -> str:
    digest = hashlib.sha256()
    for result in _results():
        digest.update(result.astype("<f8", order="C").tobytes())
    return digest.hexdigest()[:12]


def _results() -> Iterator[Floats]:
    """Results that are rounded, over samples that are exact: one array for each function that a run uses."""
    numbers = np.arange(1, _SAMPLES + 1)
    fraction = (numbers * 2_654_435_761 % 2**32 + 0.5) / 2**32  # in (0, 1), as evenly as the golden ratio can
    x = np.ldexp(fraction, numbers % 37 - 30)  # from 1e-9 to 64
    y = x[::-1].copy()
    for function in (np.sqrt, np.log, np.log1p, np.sin, np.cos, np.tan, np.arctan):
        yield function(x)
    yield from (np.exp(-x), np.expm1(-x), np.logaddexp(0.0, -x))
    yield np.arctan2(y - 1.0, x - 1.0)
    yield from (np.power(x, 3.0 * fraction), np.power(10.0, -fraction))
    few = x[:_SCALARS].tolist()  # plain numbers go to the C library
    for scalar in (math.exp, math.log, math.log1p, math.exp2):
        yield np.array([scalar(value) for value in few])
    yield np.array([value**1.5 for value in few])
    # Sums: the order of additions, and whether a product is rounded before it is added.
    yield from (np.add.reduce(x, keepdims=True), np.asarray(np.bincount(numbers % 7, x), dtype=np.float64))
    rows, columns = x[: 33 * 37].reshape(33, 37), y[: 37 * 29].reshape(37, 29)
    yield from (np.add.reduce(rows, axis=1), np.einsum("ij,ij->i", rows, rows))
    yield from (rows @ columns, rows @ columns[:, 0])  # too small for threads, whose number would matter
    square = rows[:12, :12]
    yield np.linalg.eigvalsh(square + square.T)
