"""Application of the radio's verdict: a crew gets only the beacons that decoded."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fes.arrays import geometry
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.sensing import DECODED, Beacons, Observations, Received

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class _Lookup:
    """Place of the beacon of each peer in range, for one set of pairs and one set of senders and links."""

    in_range: Edges
    ids: Ints
    links: Edges
    sender: Ints
    """Row of the peer's beacon; 0 where it is absent."""
    present: Bools
    """True if the peer's beacon is there."""
    link: Ints
    """Position of the peer's link to this robot among all links, or -1."""

    def fits(self, in_range: Edges, beacons: Beacons) -> bool:
        """True if this lookup is valid for these pairs and beacons."""
        return self.in_range is in_range and self.ids is beacons.ids and self.links is beacons.links


class Receiver:
    """Filters the beacons of each tick: it keeps those that decoded. Its cache never changes the result."""

    def __init__(self) -> None:
        self._lookup: _Lookup | None = None
        self._in_range: Edges | None = None
        self._contacts: Edges | None = None
        self._is_contact: Bools = np.zeros(0, dtype=np.bool_)
        self._places: Ints = np.zeros(0, dtype=np.int64)
        """Position among the contacts of each pair in range that is one."""

    def receive(self, observations: Observations, beacons: Beacons, contacts: Edges) -> Received:
        """The `beacons` of the previous tick that decoded, for a crew whose contacts until now are `contacts`.

        A peer in range becomes a contact when its first beacon decodes. A contact out of range is dropped.
        """
        in_range = observations.in_range
        lookup = self._lookup
        if lookup is None or not lookup.fits(in_range, beacons):
            lookup = self._lookup = _look_up(in_range, beacons)
        is_decoded = (observations.reception == DECODED) & lookup.present
        edges = self._update(in_range, is_decoded, contacts)
        sender, link = lookup.sender, lookup.link
        heard = pairs = is_decoded.nonzero()[0]
        if len(pairs) < len(in_range):
            heard = self._places.take(pairs)
            sender, link = sender.take(pairs), link.take(pairs)
        estimates, selected = _of_links(beacons, link)
        poses = beacons.poses.take(sender, axis=0)
        return Received(
            observations.tick - 1,
            edges,
            heard,
            poses[:, geometry.X],
            poses[:, geometry.Y],
            poses[:, geometry.HEADING],
            estimates,
            selected,
            _rows(beacons.statistics, sender),
            _rows(beacons.declared, sender),
            lambda: _mean_estimates(beacons).take(sender),
        )

    def _update(self, in_range: Edges, is_decoded: Bools, contacts: Edges) -> Edges:
        """The contacts now; the same object while its pairs are the same."""
        if in_range is not self._in_range or contacts is not self._contacts:
            self._in_range = in_range
            self._is_contact = in_range.after(contacts).positions >= 0
        elif len(contacts) == len(in_range) or not np.count_nonzero(is_decoded > self._is_contact):
            return contacts
        self._is_contact |= is_decoded
        self._places = np.cumsum(self._is_contact) - 1
        edges = in_range if self._is_contact.all() else in_range.select(self._is_contact)
        if edges.ids is contacts.ids and edges.keys.tobytes() == contacts.keys.tobytes():
            edges = contacts
        self._contacts = edges
        return edges


def absent(observations: Observations, senders: Collection[int]) -> list[int]:
    """Peers whose beacon of the previous tick decoded at a robot of this crew, and which are not among the `senders`.

    They are ascending.
    """
    if observations.in_range.peer_set.issubset(senders):  # the usual tick
        return []
    return sorted(set(observations.in_range.peers[observations.reception == DECODED].tolist()).difference(senders))


def missing(observations: Observations, senders: Sequence[int]) -> int:
    """Number of beacons that decoded at a robot, but whose peer is not among the `senders` of those received."""
    peers = observations.in_range.peers[observations.reception == DECODED]
    return int(np.count_nonzero(~np.isin(peers, senders)))


def _of_links(beacons: Beacons, link: Ints) -> tuple[Floats, Bools]:
    """Estimate of each link [d], NaN at position -1, and True where its sender's own rule selected it [d]."""
    if not len(beacons.links):
        return np.full(len(link), np.nan), np.zeros(len(link), dtype=np.bool_)
    estimates, selected = beacons.estimates.take(link, mode="clip"), beacons.selected.take(link, mode="clip")
    has_link = link >= 0
    if np.count_nonzero(has_link) < len(link):
        estimates[~has_link] = np.nan
        selected &= has_link
    return estimates, selected


def _rows(values: Array, sender: Ints) -> Array:
    """The rows of `values` [n, q] of each sender [d, q]."""
    return values.take(sender, axis=0) if values.shape[1] else np.empty((len(sender), 0), values.dtype)


def _mean_estimates(beacons: Beacons) -> Floats:
    """Mean estimate of each sender over all its links [n] [m]; NaN without links."""
    links = beacons.links
    if len(links) == 0:
        return np.full(len(links.ids), np.nan)
    return np.where(links.counts > 0, links.sum(beacons.estimates) / np.maximum(links.counts, 1), np.nan)


def _look_up(edges: Edges, beacons: Beacons) -> _Lookup:
    """The place of each peer's beacon among `beacons`."""
    if len(beacons.ids) == 0:
        zeros = np.zeros(len(edges), dtype=np.int64)
        return _Lookup(edges, beacons.ids, beacons.links, zeros, zeros > 0, zeros - 1)
    sender = np.minimum(np.searchsorted(beacons.ids, edges.peers), len(beacons.ids) - 1)
    present = beacons.ids[sender] == edges.peers
    return _Lookup(edges, beacons.ids, beacons.links, sender, present, beacons.links.find(edges.reverse_keys))
