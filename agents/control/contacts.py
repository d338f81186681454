"""Who is heard, and where: the peers in range, each with what its last decoded beacon said."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fes.arrays import geometry
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.contacts import NEVER, Contacts, Lookup
from fes.model.sensing import DECODED, Beacons, Observations, no_beacons


def no_contacts(ids: Ints) -> Contacts:
    """The contacts of a crew that has heard nobody."""
    return _blank(no_edges(ids))


def update(contacts: Contacts, observations: Observations, own: Floats, beacons: Beacons, timeout: int) -> Contacts:
    """Contacts after the beacons of the previous tick.

    `own` are the robots' poses [n, 3] at that tick: where both beacons decoded, a separation is formed from the
    same two poses on both sides, so r_ij = r_ji to the bit. `timeout` [ticks]: a peer unheard for longer is not
    known any more.
    """
    if observations.in_range is not contacts.edges:
        contacts = _carry(contacts, observations.in_range)
    edges = contacts.edges
    lookup = contacts.lookup if contacts.lookup.fits(edges, beacons) else _look_up(edges, beacons)
    decoded = (observations.reception == DECODED) & lookup.present
    heard, x, y = contacts.heard, contacts.x, contacts.y
    estimates, names_us = contacts.estimates, contacts.selected_by_peer
    if np.count_nonzero(decoded):
        linked = lookup.link >= 0
        heard = np.where(decoded, beacons.tick, heard)
        x = np.where(decoded, beacons.poses[:, geometry.X].take(lookup.sender), x)
        y = np.where(decoded, beacons.poses[:, geometry.Y].take(lookup.sender), y)
        told, names = np.full(len(edges), np.nan), linked
        if len(beacons.links):  # else nobody has a link, and what was heard of one before no longer holds
            told = np.where(linked, beacons.estimates.take(lookup.link, mode="clip"), np.nan)
            names = beacons.selected.take(lookup.link, mode="clip") & linked
        estimates = np.where(decoded, told, estimates)
        names_us = np.where(decoded, names, names_us)
    dx = x - own[:, geometry.X].take(edges.rows)
    dy = y - own[:, geometry.Y].take(edges.rows)
    known = heard >= observations.tick - timeout
    separation = geometry.separation(dx, dy)
    at_beacon = np.where(decoded, separation, contacts.heard_separation)
    return Contacts(edges, lookup, heard, x, y, estimates, names_us, at_beacon, known, dx, dy, separation)


def forget(contacts: Contacts, who: Bools) -> Contacts:
    """The contacts, those of the robots `who` [n] blank."""
    blank, gone = _blank(contacts.edges), who[contacts.edges.rows]
    names = (
        "heard",
        "x",
        "y",
        "estimates",
        "selected_by_peer",
        "heard_separation",
        "known",
        "dx",
        "dy",
        "separation",
    )
    kept = {name: np.where(gone, getattr(blank, name), getattr(contacts, name)) for name in names}
    return replace(contacts, **kept)


def mean_estimates(contacts: Contacts, beacons: Beacons) -> Floats:
    """What robots that have links say in the `beacons` just heard, on average at each robot [n] [m]; NaN if none."""
    links = beacons.links
    if len(links) == 0 or len(contacts.edges) == 0:
        return np.full(len(contacts.edges.ids), np.nan)
    said = links.sum(beacons.estimates) / np.maximum(links.counts, 1)
    sender = contacts.lookup.sender
    fresh = (contacts.heard == beacons.tick) & contacts.lookup.present & (links.counts.take(sender) > 0)
    count = contacts.edges.sum(fresh.astype(np.float64))
    total = contacts.edges.sum(np.where(fresh, said.take(sender), 0.0))
    return np.where(count > 0, total / np.maximum(count, 1.0), np.nan)


def all_here(contacts: Contacts, observations: Observations) -> bool:
    """Whether every beacon that the world says was decoded had come: the promise of the lockstep."""
    present = contacts.lookup.present
    return bool(present.all() or present[observations.reception == DECODED].all())


def decoded(observations: Observations) -> set[int]:
    """The peers whose beacon of the previous tick decoded at a robot of this crew."""
    return set(observations.in_range.peers[observations.reception == DECODED].tolist())


def missing(observations: Observations, senders: Sequence[int]) -> int:
    """Number of contacts whose beacon decoded and is not among those of `senders`."""
    peers = observations.in_range.peers[observations.reception == DECODED]
    return int(np.count_nonzero(~np.isin(peers, senders)))


def _look_up(edges: Edges, beacons: Beacons) -> Lookup:
    if len(beacons.ids) == 0:
        nowhere = np.zeros(len(edges), dtype=np.int64)
        return Lookup(edges, beacons.ids, beacons.links, nowhere, nowhere > 0, nowhere - 1)
    sender = np.minimum(np.searchsorted(beacons.ids, edges.peers), len(beacons.ids) - 1)
    present = beacons.ids[sender] == edges.peers
    return Lookup(edges, beacons.ids, beacons.links, sender, present, beacons.links.find(edges.reverse_keys))


def _blank(edges: Edges) -> Contacts:
    count = len(edges)
    zero = np.zeros(count)
    no = np.zeros(count, dtype=np.bool_)
    never = np.full(count, NEVER, dtype=np.int64)
    return Contacts(
        edges,
        _look_up(edges, no_beacons()),
        never,
        zero,
        zero,
        np.full(count, np.nan),
        no,
        zero,
        no,
        zero,
        zero,
        zero,
    )


def _carry(contacts: Contacts, edges: Edges) -> Contacts:
    """What was heard of the peers that stay in range; the others are forgotten."""
    blank = _blank(edges)
    if len(contacts.edges) == 0:
        return blank
    at = edges.places_in(contacts.edges)
    stays = at >= 0
    return replace(
        blank,
        heard=np.where(stays, contacts.heard[at], blank.heard),
        x=np.where(stays, contacts.x[at], blank.x),
        y=np.where(stays, contacts.y[at], blank.y),
        estimates=np.where(stays, contacts.estimates[at], blank.estimates),
        selected_by_peer=np.where(stays, contacts.selected_by_peer[at], blank.selected_by_peer),
        heard_separation=np.where(stays, contacts.heard_separation[at], blank.heard_separation),
    )
