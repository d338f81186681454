"""Directed pairs (robot, peer) of a crew, and sums over them in a fixed order.

A crew hosts n robots; each has a list of peers of its own length. Instead of padding these lists to a
rectangle [n, K], the pairs lie one after the other, sorted by robot, then by peer. A sum over a robot's
pairs is taken strictly in that order (`numpy.bincount` adds one by one), so a robot's digits do not
depend on who else shares its process.
"""

from dataclasses import dataclass
from functools import cached_property
from operator import is_ as _is

import numpy as np

from fes.arrays import Bools, Floats, Ints

_SHIFT = 32  # a pair's key is robot * 2**32 + peer: unique, and sorted as the pairs are


@dataclass(frozen=True, eq=False)
class Edges:
    """Directed pairs (robot, peer), compared by identity: the same object means the same pairs."""

    ids: Ints
    """Robot ids of the crew, ascending [n]."""
    rows: Ints
    """Row of each pair's robot in `ids`, ascending [m]."""
    peers: Ints
    """Id of each pair's peer, ascending within a row [m]."""

    def __len__(self) -> int:
        return len(self.rows)

    @staticmethod
    def key(robots: Ints, peers: Ints) -> Ints:
        """The key of pairs given by ids; any shape."""
        return (robots << _SHIFT) | peers

    @cached_property
    def keys(self) -> Ints:
        """One integer per pair, ascending [m]."""
        return self.key(self.ids[self.rows], self.peers)

    @cached_property
    def reverse_keys(self) -> Ints:
        """The key of each pair seen from the other side [m]."""
        return self.key(self.peers, self.ids[self.rows])

    @cached_property
    def reverse(self) -> Ints:
        """Position of the pair (peer, robot) for each pair (robot, peer), or -1 [m]."""
        return self.find(self.reverse_keys)

    @cached_property
    def mutual(self) -> Ints:
        """Positions of the pairs with robot < peer that stand in both directions."""
        return np.flatnonzero((self.reverse >= 0) & (self.ids[self.rows] < self.peers))

    @cached_property
    def undirected(self) -> Ints:
        """Positions of one pair for each two robots that stand in either direction."""
        return np.flatnonzero((self.reverse < 0) | (self.ids[self.rows] < self.peers))

    @cached_property
    def counts(self) -> Ints:
        """Number of peers of each robot [n]."""
        return np.bincount(self.rows, minlength=len(self.ids))

    @cached_property
    def spans(self) -> list[slice]:
        """Where each robot's pairs stand [n]."""
        ends = np.cumsum(self.counts)
        begins = ends - self.counts
        return [slice(begin, end) for begin, end in zip(begins.tolist(), ends.tolist(), strict=True)]

    @cached_property
    def starts(self) -> Ints:
        """Position of the first pair of each robot that has any."""
        counts = self.counts
        return (np.cumsum(counts) - counts)[counts > 0]

    @cached_property
    def groups(self) -> Ints:
        """For each pair, the index of its robot's entry in `starts` [m]."""
        return (np.cumsum(self.counts > 0) - 1)[self.rows]

    def find(self, keys: Ints) -> Ints:
        """Position of each key, or -1 where the pair is not here."""
        if len(self) == 0:
            return np.full(len(keys), -1, dtype=np.int64)
        at = np.minimum(np.searchsorted(self.keys, keys), len(self) - 1)
        return np.where(self.keys[at] == keys, at, -1)

    def sum(self, values: Floats) -> Floats:
        """Sum of `values` [m] over each robot's pairs, in their order [n]."""
        return np.bincount(self.rows, values, minlength=len(self.ids)).astype(np.float64, copy=False)

    def first_largest(self, values: Floats) -> Bools:
        """Mark the largest of `values` [m] of each robot; among equals the lowest peer id [m].

        >>> one = Edges(np.array([7]), np.array([0, 0, 0]), np.array([1, 2, 3]))
        >>> one.first_largest(np.array([2.0, 5.0, 5.0]))
        array([False,  True, False])
        """
        if len(self) == 0:
            return np.zeros(0, dtype=np.bool_)
        largest = np.maximum.reduceat(values, self.starts)
        at = np.flatnonzero(values == largest.take(self.groups))
        chosen = np.zeros(len(self), dtype=np.bool_)
        if len(at) > len(self.starts):
            rows = self.rows.take(at)
            at = at[np.concatenate(([True], rows[1:] != rows[:-1]))]
        chosen[at] = True
        return chosen

    def select(self, mask: Bools) -> "Edges":
        """The pairs where `mask` [m] is true."""
        return Edges(self.ids, self.rows[mask], self.peers[mask])


class Stack:
    """Edges from one list of peers per robot; the same object while every list is the same object."""

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
    """A crew without any pair."""
    nothing = np.zeros(0, dtype=np.int64)
    return Edges(ids, nothing, nothing)
