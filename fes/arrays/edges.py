"""Directed pairs (robot, peer) of a crew, and sums over them in a fixed order.

A crew hosts n robots; each has a list of peers of its own length. Instead of padding these lists to a
rectangle [n, K], the pairs lie one after the other, sorted by robot, then by peer. A sum over a robot's
pairs is taken strictly in that order (`numpy.bincount` adds term by term). So a robot's digits do not
depend on the other robots of its process.
"""

from dataclasses import dataclass
from functools import cached_property
from operator import is_ as _is
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fes.arrays.types import Bools, Floats, Ints

Number = TypeVar("Number", bound=np.generic)
"""Type of the numbers in a carried array, before and after."""

_SHIFT = 32  # a pair's key is robot * 2**32 + peer: unique, and sorted as the pairs are


@dataclass(frozen=True, eq=False)
class Edges:
    """Directed pairs (robot, peer), m of them, compared by identity: the same object means the same pairs."""

    ids: Ints
    """Robot ids of the crew, ascending [n]."""
    rows: Ints
    """Row of each pair's robot in `ids`, ascending [m]."""
    peers: Ints
    """Id of each pair's peer, ascending within a row [m]."""

    def __len__(self) -> int:
        return len(self.rows)

    def __getstate__(self) -> dict[str, Ints]:
        # Derived arrays are computed again on demand.
        return {"ids": self.ids, "rows": self.rows, "peers": self.peers}

    @staticmethod
    def key(robots: Ints, peers: Ints) -> Ints:
        """The key of pairs given by ids; any shape."""
        return (robots << _SHIFT) | peers

    @cached_property
    def robots(self) -> Ints:
        """Id of each pair's robot [m]."""
        return self.ids[self.rows]

    @cached_property
    def keys(self) -> Ints:
        """One integer per pair, ascending [m]."""
        return self.key(self.robots, self.peers)

    @cached_property
    def reverse_keys(self) -> Ints:
        """The key of each pair seen from the other side [m]."""
        return self.key(self.peers, self.robots)

    @cached_property
    def reverse(self) -> Ints:
        """Position of the pair (peer, robot) for each pair (robot, peer), or -1 [m]."""
        return self.find(self.reverse_keys)

    @cached_property
    def mutual(self) -> Ints:
        """Positions of the pairs with robot < peer whose reverse is among the edges too."""
        return np.flatnonzero((self.reverse >= 0) & (self.robots < self.peers))

    @cached_property
    def undirected(self) -> Ints:
        """Positions of one pair for each two robots that are linked in either direction [u]."""
        return np.flatnonzero((self.reverse < 0) | (self.robots < self.peers))

    @cached_property
    def counts(self) -> Ints:
        """Number of peers of each robot [n]."""
        return np.bincount(self.rows, minlength=len(self.ids))

    @cached_property
    def shares(self) -> Floats:
        """One over the number of the robot's other pairs; 1 for a robot with a single pair [m]."""
        shares: Floats = (1.0 / np.maximum(self.counts - 1, 1)).take(self.rows)
        return shares

    @cached_property
    def peer_set(self) -> frozenset[int]:
        """Ids of the peers of all robots."""
        return frozenset(self.peers.tolist())

    @cached_property
    def spans(self) -> list[slice]:
        """Positions of each robot's pairs [n]."""
        ends = np.cumsum(self.counts)
        begins = ends - self.counts
        return [slice(begin, end) for begin, end in zip(begins.tolist(), ends.tolist(), strict=True)]

    @cached_property
    def begins(self) -> Ints:
        """Position of the first pair of each robot, then the number of all pairs [n + 1]."""
        return np.concatenate(([0], np.cumsum(self.counts)))

    @cached_property
    def starts(self) -> Ints:
        """Position of the first pair of each robot that has any."""
        counts = self.counts
        return (np.cumsum(counts) - counts)[counts > 0]

    @cached_property
    def groups(self) -> Ints:
        """For each pair, the index of its robot's entry in `starts` [m]."""
        return (np.cumsum(self.counts > 0) - 1)[self.rows]

    @cached_property
    def ranks(self) -> Ints:
        """Number of pairs of the same robot before each pair [m]."""
        return np.arange(len(self)) - (np.cumsum(self.counts) - self.counts)[self.rows]

    @cached_property
    def _leading(self) -> dict[int, Ints]:
        """k -> positions of the first k pairs of each robot."""
        return {}

    def find(self, keys: Ints) -> Ints:
        """Position of the pair of each of `keys`, or -1 where these edges lack it."""
        if len(self) == 0:
            return np.full(len(keys), -1, dtype=np.int64)
        positions = self.keys.searchsorted(keys)
        return np.where(self.keys.take(positions, mode="clip") == keys, positions, -1)

    def after(self, old: "Edges") -> "Transition":
        """The transition from the edges `old` to these."""
        return Transition(np.arange(len(self)) if old is self else old.find(self.keys))

    def carry(self, values: NDArray[Number], old: "Edges", fill: float, axis: int = 0) -> NDArray[Number]:
        """`values` of the pairs of `old`, for the pairs of these edges; a pair that is new gets `fill`.

        To carry several arrays, use `after`, which looks the pairs up once.
        """
        return values if old is self else self.after(old).carry(values, fill, axis)

    def sum(self, values: Floats) -> Floats:
        """Sum of `values` [m] over each robot's pairs, in their order [n]."""
        return np.bincount(self.rows, values, minlength=len(self.ids)).astype(np.float64, copy=False)

    def first_smallest(self, values: Floats) -> Ints:
        """Position of the smallest of each robot's `values` [m]; among equals that of the lowest peer id.

        >>> edges = Edges(np.array([7]), np.array([0, 0, 0]), np.array([1, 2, 3]))
        >>> edges.first_smallest(np.array([5.0, 2.0, 2.0]))
        array([1])
        """
        if len(self) == 0:
            return self.rows
        least = np.minimum.reduceat(values, self.starts)
        positions: Ints = np.equal(values, least.take(self.groups)).nonzero()[0]
        rows = self.rows.take(positions)
        is_tie = rows[1:] == rows[:-1]  # a count would miss ties beside robots whose values are NaN
        return positions[np.concatenate(([True], ~is_tie))] if np.count_nonzero(is_tie) else positions

    def smallest(self, values: Floats, k: int) -> Ints:
        """Positions of each robot's `k` smallest `values` [m]; among equals the lowest peer id first.

        >>> edges = Edges(np.array([7]), np.array([0, 0, 0]), np.array([1, 2, 3]))
        >>> edges.smallest(np.array([5.0, 2.0, 2.0]), 2)
        array([1, 2])
        """
        if k not in self._leading:
            self._leading[k] = np.flatnonzero(self.ranks < k)
        return np.lexsort((values, self.rows)).take(self._leading[k])

    def select(self, mask: Bools) -> "Edges":
        """The pairs where `mask` [m] is true."""
        return Edges(self.ids, self.rows[mask], self.peers[mask])


@dataclass(frozen=True, eq=False)
class Transition:
    """The transition from one set of pairs to the next, which converts arrays over the old pairs to the new ones."""

    positions: Ints
    """Position of each new pair among the old ones, or -1 for a pair that is not among them [m]."""

    @cached_property
    def is_new(self) -> Bools:
        """True for a pair that is not among the old ones [m]."""
        return self.positions < 0

    def carry(self, values: NDArray[Number], fill: float, axis: int = 0) -> NDArray[Number]:
        """`values` of the old pairs, along `axis` >= 0, for the new ones: a new array of the same type.

        Each pair keeps its values; a new pair gets `fill`. Other axes keep their lengths.
        """
        if values.shape[axis] == 0:
            shape = (*values.shape[:axis], len(self.positions), *values.shape[axis + 1 :])
            return np.full(shape, fill, values.dtype)
        carried = values.take(self.positions, axis, mode="clip")
        carried[(slice(None),) * axis + (self.is_new,)] = fill
        return carried


class Stack:
    """Makes edges from one list of peers per robot; returns the same object while every list is the same object."""

    def __init__(self) -> None:
        self._lists: list[Ints] = []
        self._edges: Edges | None = None

    def edges(self, ids: Ints, lists: list[Ints]) -> Edges:
        """The pairs of robots `ids` [n] and the peers in `lists` [n], each ascending."""
        last = self._edges
        same = last is not None and last.ids is ids and all(map(_is, lists, self._lists))
        if last is None or not same:
            rows = np.repeat(np.arange(len(ids)), [len(peers) for peers in lists])
            last = self._edges = Edges(ids, rows, np.concatenate(lists) if lists else rows)
            self._lists = lists
        return last


def no_edges(ids: Ints) -> Edges:
    """The edges of a crew without any pair."""
    nothing = np.zeros(0, dtype=np.int64)
    return Edges(ids, nothing, nothing)
