"""The compiled index of the channel's formula. Only `agents.laws.oracle` loads it."""

import ctypes
from ctypes import c_double, c_int64
from functools import cache
from typing import Any

from fes.arithmetic.core import library

NAME = "formula_index"


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
    return library.load(__file__, NAME, lambda found: bool(found.fes_formula_index))


def compiled(settings: Formula) -> tuple[int, Any] | None:
    """The address of the compiled index, and its settings; None where numpy computes."""
    found = load()
    if found is None:
        return None
    return ctypes.cast(found.fes_formula_index, ctypes.c_void_p).value or 0, settings
