"""Neighbor rules: the contacts that a robot selects as neighbors, only from the beacons that it hears.

Ties break by robot id: pairs are ordered by peer id, and a rule takes the first of equals.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from fes.arrays import geometry
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats, Ints
from fes.extension.context import LawContext
from fes.extension.protocols import NoParameters
from fes.model.config import FormationConfig
from fes.model.contacts import Contacts

FEW = 4096
"""Largest number of triples (robot, peer, witness) that are all examined in every tick: a selection costs more."""

BLOCK = 2**16
"""Number of triples examined at once: memory grows with the contacts, not with contacts times degree."""

NEAREST = 16
"""Number of a robot's nearest contacts that are tried first as witnesses in a crowd: they exclude most pairs."""


class Witnesses:
    """Third robots that may exclude a pair, for one set of contacts.

    A cache: it changes the amount of computing, never the result. For few contacts it holds all triples. For many it
    holds the robot that last excluded each pair; most of them still do in the next tick.
    """

    def __init__(self, edges: Edges, before: "Witnesses | None" = None) -> None:
        """Witnesses for the contacts `edges`. Contacts that remain keep their last witness of `before`."""
        self.edges = edges
        self.all: tuple[Ints, Ints] | None = None
        self.last: Ints = np.full(len(edges), -1, dtype=np.int64)
        if int(np.add.reduce(np.square(edges.counts))) <= FEW:
            self.all = self.of(np.arange(len(edges)), self.counts(np.arange(len(edges))))
        elif before is not None and len(before.edges):
            self._carry(before)

    def counts(self, pairs: Ints) -> Ints:
        """Number of contacts of the robot of each of `pairs` [t]."""
        counts: Ints = self.edges.counts[self.edges.rows[pairs]]
        return counts

    def of(self, pairs: Ints, counts: Ints) -> tuple[Ints, Ints]:
        """Positions of (robot, peer) and of (robot, witness) for all contacts of the robots of `pairs` [t]."""
        first = (np.cumsum(self.edges.counts) - self.edges.counts)[self.edges.rows[pairs]]
        offset = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
        return np.repeat(pairs, counts), np.repeat(first, counts) + offset

    def blocks(self, pairs: Ints, counts: Ints) -> Iterator[tuple[Ints, Ints]]:
        """As `of`, in blocks of consecutive `pairs` with about BLOCK triples each."""
        ends = np.cumsum(counts)
        cuts = np.searchsorted(ends, np.arange(BLOCK, ends[-1], BLOCK))
        return map(self.of, np.split(pairs, cuts), np.split(counts, cuts))

    def _carry(self, before: "Witnesses") -> None:
        old = self.edges.carry(before.last, before.edges, -1)
        self.last = np.where(old >= 0, self.edges.find(before.edges.keys[old]), -1)


def disk(contacts: Contacts) -> Bools:
    """Every contact is a neighbor: the disk graph, [S]_ij of (2) with r_ij <= r_x [m]."""
    return contacts.known


def two_nearest(contacts: Contacts) -> Bools:
    """The two nearest contacts (the paper's footnote 2); a link exists if either end selected it [m]."""
    known, reach = contacts.known, contacts.separation
    are_all = np.count_nonzero(known) == len(known)
    chosen = np.zeros(len(known), dtype=np.bool_)
    chosen[contacts.edges.smallest(reach if are_all else np.where(known, reach, np.inf), 2)] = True
    if not are_all:
        chosen &= known
    return chosen


def relative_neighborhood(contacts: Contacts, witnesses: Witnesses, tolerance: float = 0.0) -> Bools:
    """The contacts to which no third robot is closer from both ends, by the share `tolerance` of their length [m].

    Edge i-j exists iff there is no k with max(d_ik, d_jk) < (1 - tolerance) d_ij. Such a k is in range of both i and
    j, so both select alike from the beacons that they hear. A tolerance only adds links.
    """
    known = contacts.known
    reach = np.where(known, contacts.separation, np.inf)
    if tolerance > 0.0:  # from here on, separations stand for the pairs only
        contacts = contacts._replace(separation=(1.0 - tolerance) * contacts.separation)
    if witnesses.all is not None:
        pair, witness = witnesses.all
        excluded = np.bincount(pair, _excludes(contacts, reach, pair, witness), minlength=len(known))
        chosen: Bools = np.logical_and(known, excluded == 0.0)
        return chosen
    last = witnesses.last
    remembered = np.flatnonzero(last >= 0)
    still = _excludes(contacts, reach, remembered, last[remembered])
    last[remembered[~still]] = -1
    suspects = np.flatnonzero(known & (last < 0))
    for pair, witness in _candidates(contacts, reach, witnesses, suspects):
        excluding = np.flatnonzero(_excludes(contacts, reach, pair, witness))
        last[pair[excluding]] = witness[excluding]
    remaining: Bools = np.logical_and(known, last < 0)
    return remaining


def _candidates(
    contacts: Contacts, reach: Floats, witnesses: Witnesses, suspects: Ints
) -> Iterable[tuple[Ints, Ints]]:
    """All triples of the `suspects`, in blocks. In a crowd, only of those suspects that no near robot excludes."""
    counts = witnesses.counts(suspects)
    total = int(counts.sum())
    if total <= BLOCK:
        return (witnesses.of(suspects, counts),)
    if total > NEAREST * len(reach):
        suspects = _try_nearest(contacts, reach, witnesses.last, suspects)
        counts = witnesses.counts(suspects)
    return witnesses.blocks(suspects, counts) if len(suspects) else ()


def _try_nearest(contacts: Contacts, reach: Floats, last: Ints, suspects: Ints) -> Ints:
    """The `suspects` that none of their robot's NEAREST contacts excludes. `last` [m] gets the others' witness."""
    edges, left = contacts.edges, np.fmin(reach, np.inf)
    for _ in range(NEAREST):
        nearest = edges.first_smallest(left)
        left[nearest] = np.inf
        witness = nearest.take(edges.groups.take(suspects))
        excluded = _excludes(contacts, reach, suspects, witness)
        last[suspects[excluded]] = witness[excluded]
        suspects = suspects[~excluded]
    return suspects


def _excludes(contacts: Contacts, reach: Floats, pair: Ints, witness: Ints) -> Bools:
    """True if max(d_ik, d_jk) < d_ij, for positions of (i, j) and of (i, k) [t]; never for k = j.

    `contacts` has d_ij, and `reach` d_ik.
    """
    if len(pair) > BLOCK:
        parts = [slice(first, first + BLOCK) for first in range(0, len(pair), BLOCK)]
        return np.concatenate([_excludes(contacts, reach, pair[part], witness[part]) for part in parts])
    across = geometry.separation(
        contacts.x.take(witness) - contacts.x.take(pair), contacts.y.take(witness) - contacts.y.take(pair)
    )
    return np.less(np.maximum(reach.take(witness), across), contacts.separation.take(pair))


class Disk:
    """The rule `disk`."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: LawContext) -> None:
        pass

    def __call__(self, contacts: Contacts) -> Bools:
        """True for each contact that its robot selects [m]."""
        return disk(contacts)


class TwoNearest(Disk):
    """The rule `two_nearest`."""

    def __call__(self, contacts: Contacts) -> Bools:
        """True for each contact that its robot selects [m]."""
        return two_nearest(contacts)


class RelativeNeighborhood(Disk):
    """The rule `relative_neighborhood`, with its cache of witnesses."""

    def __init__(self, parameters: NoParameters, context: LawContext) -> None:
        self._witnesses, self._tolerance = Witnesses(no_edges(context.ids)), 0.0

    def __call__(self, contacts: Contacts) -> Bools:
        """True for each contact that its robot selects [m]."""
        if self._witnesses.edges is not contacts.edges:
            self._witnesses = Witnesses(contacts.edges, self._witnesses)
        return relative_neighborhood(contacts, self._witnesses, self._tolerance)


class TolerantRelativeNeighborhood(RelativeNeighborhood):
    """The rule `tolerant_relative_neighborhood`.

    The three links of a triangle of a lattice are equally long. Without a tolerance, errors of centimeters end half
    the links of a patch.
    """

    Parameters = FormationConfig  # type: ignore[assignment]

    def __init__(self, parameters: FormationConfig, context: LawContext) -> None:
        super().__init__(NoParameters(), context)
        self._tolerance = parameters.link_tolerance
