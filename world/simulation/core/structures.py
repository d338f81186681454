"""The structures of world.h and tick.c, and the places of the arrays in a buffer."""

import ctypes
from ctypes import c_double, c_int64, c_uint64, c_void_p
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fes.arithmetic.core.library import Buffer

SENT, HEARD, DRAWN, TOTALS = range(4)
"""Totals of a tick."""

_FIELDS: dict[str, type] = {
    "poses": np.float64,
    "totals": np.int64,
    "separation": np.float64,
    "mask": np.bool_,
    "begin": np.int64,
    "rows": np.int64,
    "peers": np.int64,
    "pair": np.int64,
    "age": np.int64,
    "sent": np.int64,
    "decoded": np.int64,
    "gap": np.int64,
    "longest_gap": np.int64,
    "probability": np.float64,
    "outage_sum": np.float64,
    "reception": np.uint8,
    "burst": np.uint8,
}
"""The arrays of a tick, in the order of fes_world_layout, and their types."""

LEDGER = tuple(_FIELDS)[8:]
"""The arrays of the contacts."""


class Settings(ctypes.Structure):
    """The channel and the bodies."""

    _fields_ = (
        ("dt", c_double),
        ("communication_range", c_double),
        ("model", c_int64),
        ("is_certain", c_int64),
        ("scale", c_double),
        ("exponent", c_double),
        ("midpoint", c_double),
        ("width", c_double),
        ("key0", c_uint64),
        ("key1", c_uint64),
    )


class CandidateList(ctypes.Structure):
    """Pairs of robots that may be in range: `Candidates` in world.h."""

    _fields_ = (
        ("count", c_int64),
        ("a", c_void_p),
        ("b", c_void_p),
        ("positions", c_void_p),
        ("most_moved", c_double),
    )


class Input(ctypes.Structure):
    """The inputs of a tick."""

    _fields_ = (
        ("robots", c_int64),
        ("tick", c_int64),
        ("poses", c_void_p),
        ("twists", c_void_p),
        ("present", c_void_p),
        ("factor", c_void_p),
        ("before", CandidateList),
        ("now", CandidateList),
        ("sent", c_int64),
        ("decoded", c_int64),
        ("least", c_double),
    )


class Layout:
    """The places of the arrays in a buffer, for a number of robots and of candidates."""

    def __init__(self, library: ctypes.CDLL, robots: int, candidates: int) -> None:
        places = (c_int64 * len(_FIELDS))()
        length: int = library.fes_world_layout(robots, candidates, places)
        self.buffer = ctypes.c_char * length
        """Class of a buffer, of zeros: its address is known, and numpy arrays can lie in it."""
        self.places = dict(zip(_FIELDS, places, strict=True))
        """Place of each array [bytes]."""

    def view(self, buffer: Buffer, name: str, shape: int | tuple[int, ...]) -> NDArray[Any]:
        """The first numbers of one array of a buffer, as an array of this shape."""
        return np.ndarray(shape, _FIELDS[name], buffer, self.places[name])


class Batch(ctypes.Structure):
    """The payloads of one tick: `Batch` in messages.h."""

    _fields_ = (("version", c_int64), ("tick", c_int64), ("robots", c_int64), ("count", c_int64))


class Parts(ctypes.Structure):
    """The parts of a command beside its twist: `Parts` in messages.h."""

    _fields_ = tuple(
        (name, c_int64) for name in ("links_at", "links_length", "estimates", "learnt", "details", "is_model_free")
    )
