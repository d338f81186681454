"""Updates of contacts: the peers in range of each robot, each with the content of its last decoded beacon."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fes.arrays import geometry
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.contacts import NEVER, Contacts, Lookup
from fes.model.sensing import DECODED, Beacons, Observations, no_beacons

Array = NDArray[Any]


def no_contacts(ids: Ints) -> Contacts:
    """The contacts of a crew that has heard no beacon."""
    edges = no_edges(ids)
    floats, bools = np.zeros(0), np.zeros(0, dtype=np.bool_)
    lookup = _look_up(edges, no_beacons())
    return Contacts(edges, lookup, edges.rows, floats, floats, floats, bools, floats, bools, floats, floats, floats)


def update(contacts: Contacts, observations: Observations, own: Floats, beacons: Beacons, timeout: int) -> Contacts:
    """The contacts after the beacons of the previous tick.

    `own` holds the robots' poses [n, 3] at that tick. Where both beacons decoded, both ends compute the separation
    from the same two poses, so r_ij = r_ji to the bit. A peer unheard for more than `timeout` [ticks] is no longer
    known.
    """
    if observations.in_range is not contacts.edges:
        carry = observations.in_range.after(contacts.edges).carry
        contacts = _converted(contacts, observations.in_range, carry)
    edges = contacts.edges
    lookup = contacts.lookup if contacts.lookup.fits(edges, beacons) else _look_up(edges, beacons)
    decoded = (observations.reception == DECODED) & lookup.present
    heard, x, y = contacts.heard, contacts.x, contacts.y
    estimates, selected_by_peer = contacts.estimates, contacts.selected_by_peer
    if np.count_nonzero(decoded):
        linked = lookup.link >= 0
        heard = np.where(decoded, beacons.tick, heard)
        x = np.where(decoded, beacons.poses[:, geometry.X].take(lookup.sender), x)
        y = np.where(decoded, beacons.poses[:, geometry.Y].take(lookup.sender), y)
        received, selected = np.full(len(edges), np.nan), linked
        if len(beacons.links):  # else no sender has a link, and earlier estimates no longer hold
            received = np.where(linked, beacons.estimates.take(lookup.link, mode="clip"), np.nan)
            selected = beacons.selected.take(lookup.link, mode="clip") & linked
        estimates = np.where(decoded, received, estimates)
        selected_by_peer = np.where(decoded, selected, selected_by_peer)
    dx = x - own[:, geometry.X].take(edges.rows)
    dy = y - own[:, geometry.Y].take(edges.rows)
    known = heard >= observations.tick - timeout
    separation = geometry.separation(dx, dy)
    heard_separation = np.where(decoded, separation, contacts.heard_separation)
    return Contacts(
        edges, lookup, heard, x, y, estimates, selected_by_peer, heard_separation, known, dx, dy, separation
    )


def forget(contacts: Contacts, restarted: Bools) -> Contacts:
    """The contacts, with those of the robots `restarted` [n] reset to the values before the first beacon."""
    blank = restarted[contacts.edges.rows]
    return _converted(contacts, contacts.edges, lambda values, initial: np.where(blank, initial, values))


def mean_estimates(contacts: Contacts, beacons: Beacons) -> Floats:
    """Mean of what each robot's peers estimate on average [n] [m].

    Only peers count that were heard at the tick of `beacons` and have links; NaN without such a peer.
    """
    links = beacons.links
    if len(links) == 0 or len(contacts.edges) == 0:
        return np.full(len(contacts.edges.ids), np.nan)
    means = links.sum(beacons.estimates) / np.maximum(links.counts, 1)
    sender = contacts.lookup.sender
    fresh = (contacts.heard == beacons.tick) & contacts.lookup.present & (links.counts.take(sender) > 0)
    count = contacts.edges.sum(fresh.astype(np.float64))
    total = contacts.edges.sum(np.where(fresh, means.take(sender), 0.0))
    return np.where(count > 0, total / np.maximum(count, 1.0), np.nan)


def have_arrived(contacts: Contacts, observations: Observations) -> bool:
    """True if each beacon that decoded, according to the world, has arrived: the guarantee of the lockstep."""
    present = contacts.lookup.present
    return bool(present.all() or present[observations.reception == DECODED].all())


def decoded(observations: Observations) -> set[int]:
    """Ids of the peers whose beacon of the previous tick decoded at a robot of this crew."""
    return set(observations.in_range.peers[observations.reception == DECODED].tolist())


def missing(observations: Observations, senders: Sequence[int]) -> int:
    """Number of contacts whose beacon decoded, but whose peer is not among the `senders` of the beacons received."""
    peers = observations.in_range.peers[observations.reception == DECODED]
    return int(np.count_nonzero(~np.isin(peers, senders)))


def _look_up(edges: Edges, beacons: Beacons) -> Lookup:
    """The index of each contact's beacon among `beacons`."""
    if len(beacons.ids) == 0:
        zeros = np.zeros(len(edges), dtype=np.int64)
        return Lookup(edges, beacons.ids, beacons.links, zeros, zeros > 0, zeros - 1)
    sender = np.minimum(np.searchsorted(beacons.ids, edges.peers), len(beacons.ids) - 1)
    present = beacons.ids[sender] == edges.peers
    return Lookup(edges, beacons.ids, beacons.links, sender, present, beacons.links.find(edges.reverse_keys))


def _converted(contacts: Contacts, edges: Edges, convert: Callable[[Array, float], Array]) -> Contacts:
    """The contacts over `edges`, each array converted by `convert(values, value before the first beacon)`."""
    return Contacts(
        edges,
        _look_up(edges, no_beacons()) if edges is not contacts.edges else contacts.lookup,
        heard=convert(contacts.heard, NEVER),
        x=convert(contacts.x, 0.0),
        y=convert(contacts.y, 0.0),
        estimates=convert(contacts.estimates, np.nan),
        selected_by_peer=convert(contacts.selected_by_peer, False),
        heard_separation=convert(contacts.heard_separation, 0.0),
        known=convert(contacts.known, False),
        dx=convert(contacts.dx, 0.0),
        dy=convert(contacts.dy, 0.0),
        separation=convert(contacts.separation, 0.0),
    )
