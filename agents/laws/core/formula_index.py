"""The compiled index of the channel's formula. Only `agents.laws.oracle` loads it."""

import ctypes
import hashlib
import math
from ctypes import c_double, c_int64, c_void_p
from functools import cache
from typing import Any

import numpy as np

from fes.arithmetic.core import library

NAME = "formula_index"

EXPECTED = "cb01936f9bd2"
"""Hash of the results of the self-test."""


class Formula(ctypes.Structure):
    """The settings of the index: `Formula` in formula_index.c."""

    _fields_ = (
        ("minimum_separation", c_double),
        ("shape_exponent", c_double),
        ("share_of_reach", c_double),
        ("loss", c_double),
        ("path_loss_exponent", c_double),
        ("midpoint", c_double),
        ("width", c_double),
        ("is_logistic", c_int64),
        ("is_log", c_int64),
        ("trusted_share", c_double),
        ("trusted_length", c_double),
    )


@cache
def load() -> ctypes.CDLL | None:
    """The library; None where numpy computes."""
    return library.load(__file__, NAME, lambda loaded: digest(loaded) == EXPECTED)


def digest(loaded: ctypes.CDLL) -> str:
    """Hash of the index and its slopes at 200 separations, of each channel and with both transforms."""
    loaded.fes_formula_index.argtypes = [c_void_p, c_int64, *[c_void_p] * 5]
    loaded.fes_formula_index.restype = None
    separation, result = np.arange(1, 201) * 0.75, hashlib.sha256()
    for is_logistic, is_log, shape in ((0, 1, 4.0), (0, 0, 2.5), (1, 1, 3.3)):
        settings = Formula(50.0, shape, 0.0625, 2e-7, 3.0, 80.0, 12.0, is_logistic, is_log, 0.1, math.inf)
        results = np.empty((4, len(separation)))
        rows = (row.ctypes.data for row in results)
        loaded.fes_formula_index(ctypes.addressof(settings), len(separation), separation.ctypes.data, *rows)
        result.update(results.astype("<f8").tobytes())
    return result.hexdigest()[:12]


def compiled(settings: Formula) -> tuple[int, Any] | None:
    """The address of the compiled index, and its settings; None where numpy computes."""
    loaded = load()
    if loaded is None:
        return None
    return ctypes.cast(loaded.fes_formula_index, ctypes.c_void_p).value or 0, settings
