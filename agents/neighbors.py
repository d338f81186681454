"""Graph rules: which of its contacts a robot chooses as neighbors, from what it hears alone.

Ties break by robot id: pairs are ordered by peer id, and the first of equals is taken.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from agents.contacts import Contacts
from fes import geometry
from fes.arrays import Bools, Ints
from fes.edges import Edges


@dataclass(frozen=True, eq=False)
class Triples:
    """All (robot, peer, witness) with peer and witness two different contacts of the robot.

    It changes only with the set of contacts, so a crew keeps it between ticks.
    """

    edges: Edges

    @cached_property
    def pair(self) -> Ints:
        """Position of (robot, peer), ascending [t]."""
        return self._both[0]

    @cached_property
    def witness(self) -> Ints:
        """Position of (robot, witness) [t]."""
        return self._both[1]

    @cached_property
    def starts(self) -> Ints:
        """First triple of each pair that has any [m]."""
        others = (self.edges.counts - 1)[self.edges.rows]
        return np.cumsum(others) - others

    @cached_property
    def _both(self) -> tuple[Ints, Ints]:
        counts = self.edges.counts
        first = np.cumsum(counts) - counts
        pairs, witnesses = [], []
        for begin, count in zip(first.tolist(), counts.tolist(), strict=True):
            pair, witness = np.divmod(np.arange(count * count), max(count, 1))
            other = pair != witness
            pairs.append(begin + pair[other])
            witnesses.append(begin + witness[other])
        return np.concatenate(pairs), np.concatenate(witnesses)


def disk(contacts: Contacts, triples: Triples) -> Bools:
    """Every contact is a neighbor: the disk graph, [S]_ij of (2) with r_ij <= r_x [m]."""
    return contacts.known


def two_nearest(contacts: Contacts, triples: Triples) -> Bools:
    """The two nearest contacts (the paper's footnote 2); an edge stands if either end chose it [m]."""
    remaining = np.where(contacts.known, -contacts.separation, -np.inf)
    first = contacts.edges.first_largest(remaining)
    second = contacts.edges.first_largest(np.where(first, -np.inf, remaining))
    return (first | second) & contacts.known


def relative_neighborhood(contacts: Contacts, triples: Triples) -> Bools:
    """The contacts to which no third robot is closer from both ends [m].

    Edge i-j stands iff there is no k with max(d_ik, d_jk) < d_ij. Such a k is in range of both i and j, so
    both find the same answer from what they hear.
    """
    known = contacts.known
    if len(triples.pair) == 0:
        return known
    pair, witness = triples.pair, triples.witness
    far = np.where(known, contacts.separation, np.inf)
    d_ij = contacts.separation.take(pair)
    d_ik = far.take(witness)
    d_jk = geometry.separation(
        contacts.x.take(witness) - contacts.x.take(pair), contacts.y.take(witness) - contacts.y.take(pair)
    )
    excluded = np.maximum(d_ik, d_jk) < d_ij
    count = np.bincount(pair, excluded, minlength=len(known))
    chosen: Bools = known & (count == 0)
    return chosen


Rule = Callable[[Contacts, Triples], Bools]

RULES: dict[str, Rule] = {
    "disk": disk,
    "two_nearest": two_nearest,
    "relative_neighborhood": relative_neighborhood,
}
