"""The robots' links in the compiled core: their separations and errors. Twin: `world.metrics.link_errors`."""

import ctypes
from ctypes import c_double, c_int64, c_void_p
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from fes.arithmetic.core.library import Buffer
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints

DISAGREEMENT, ESTIMATE_ERROR, SEPARATION_ERROR, ESTIMATES = range(4)
"""The numbers of links: the last one is the sum of all estimates."""

NUMBERS = 4


class Links(ctypes.Structure):
    """The links in use: `Links` in links.c."""

    _fields_ = (
        ("links", c_int64),
        ("pairs", c_int64),
        ("both", c_int64),
        ("a", c_void_p),
        ("b", c_void_p),
        ("forward", c_void_p),
        ("backward", c_void_p),
    )


class _Known(NamedTuple):
    """A set of links as the library sees it."""

    structure: Links
    address: int
    arrays: list[Ints]
    """Those to which the structure points."""
    buffer: type[Buffer]
    """Class of a buffer for a number of each link."""
    robots: int
    """Number of robots, at least, that these links need."""


class LinkKernels:
    """Two functions of the world's library, and the data of each set of links that they need."""

    def __init__(self, library: ctypes.CDLL) -> None:
        # The calls are short: to release the interpreter's lock would take as long.
        short = ctypes.PyDLL(None, handle=library._handle)
        self._separations, self._errors = short.fes_world_separations, short.fes_world_link_errors
        self._separations.argtypes = [c_void_p] * 3
        self._errors.argtypes = [c_void_p] * 3 + [c_double, c_void_p]
        self._separations.restype = self._errors.restype = None
        self._known: WeakKeyDictionary[Edges, _Known] = WeakKeyDictionary()

    def separations(self, links: Edges, poses: Floats) -> Floats:
        """True separation of each of `links.undirected` [u] [m], of robots at `poses` [n, 3]."""
        known = self._known.get(links) or self._learn(links)
        if len(poses) < known.robots:
            raise ValueError(f"links of {known.robots} robots, poses of {len(poses)}")
        result = known.buffer()
        self._separations(known.address, poses.tobytes(), ctypes.addressof(result))
        return np.ndarray(known.structure.links, np.float64, result)

    def errors(self, links: Edges, estimates: Floats, separation: Floats, optimal: float) -> list[float]:
        """The NUMBERS of links with `estimates` [m] and `separation` [u], if `optimal` is the right one [m]."""
        known = self._known.get(links) or self._learn(links)
        if (len(estimates), len(separation)) != (len(links), known.structure.links):
            raise ValueError(f"{len(links)} links, {len(estimates)} estimates and {len(separation)} separations")
        values = estimates.tobytes(), separation.tobytes()  # copies: to ask numpy for an address takes longer
        numbers = (c_double * NUMBERS)()  # of this call: another thread may compute another run
        self._errors(known.address, *values, optimal, ctypes.addressof(numbers))
        return numbers[:]

    def _learn(self, links: Edges) -> _Known:
        undirected, mutual = links.undirected, links.mutual
        arrays = [links.rows[undirected], links.peers[undirected], mutual, links.reverse[mutual]]
        structure = Links(len(undirected), len(links), len(mutual), *(array.ctypes.data for array in arrays))
        robots = 1 + max((int(array.max()) for array in arrays[:2] if len(array)), default=-1)
        buffer = ctypes.c_char * (8 * len(undirected))
        known = self._known[links] = _Known(structure, ctypes.addressof(structure), arrays, buffer, robots)
        return known
