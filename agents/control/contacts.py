"""Updates of contacts: the peers that each robot has heard, each with the content of its last beacon."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fes.arrays import geometry
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.contacts import NEVER, Contacts
from fes.model.sensing import Received

Array = NDArray[Any]


def no_contacts(ids: Ints, statistics: int, declared: int) -> Contacts:
    """The contacts of a crew that has heard no beacon; a beacon has this many `statistics` and `declared` bytes."""
    nothing = no_edges(ids)
    floats, bools = np.zeros(0), np.zeros(0, dtype=np.bool_)
    numbers, declared_bytes = np.zeros((0, statistics)), np.zeros((0, declared), np.uint8)
    of_beacons = nothing.rows, floats, floats, floats, floats, bools, numbers, declared_bytes
    return Contacts(nothing, *of_beacons, floats, bools, floats, floats, floats)


def update(contacts: Contacts, received: Received, own: Floats, timeout: int) -> Contacts:
    """The contacts after the beacons of the previous tick.

    `own` holds the robots' poses [n, 3] at that tick. Where both beacons decoded, both ends compute the separation
    from the same two poses, so r_ij = r_ji to the bit. A peer unheard for more than `timeout` [ticks] is no longer
    known.
    """
    contacts = _carried(contacts, received.edges)
    edges, heard = contacts.edges, received.heard
    last = contacts.heard.copy()
    last[heard] = received.tick
    x, y = _replaced(contacts.x, heard, received.x), _replaced(contacts.y, heard, received.y)
    dx = x - own[:, geometry.X].take(edges.rows)
    dy = y - own[:, geometry.Y].take(edges.rows)
    separation = geometry.separation(dx, dy)
    return Contacts(
        edges,
        last,
        x,
        y,
        _replaced(contacts.heading, heard, received.heading),
        _replaced(contacts.estimates, heard, received.estimates),
        _replaced(contacts.selected_by_peer, heard, received.selected),
        _shared(contacts.statistics, heard, received.statistics),
        _shared(contacts.declared, heard, received.declared),
        _replaced(contacts.heard_separation, heard, separation.take(heard)),
        last >= received.tick + 1 - timeout,
        dx,
        dy,
        separation,
    )


def forget(contacts: Contacts, restarted: Bools) -> Contacts:
    """The contacts without those of the robots `restarted` [n]."""
    return _carried(contacts, contacts.edges.select(~restarted[contacts.edges.rows]))


def mean_estimates(edges: Edges, received: Received) -> Floats:
    """Mean of what each robot's peers estimate on average [n] [m], by the beacons `received`.

    Only peers that have links count; NaN without such a peer.
    """
    means = np.full(len(edges), np.nan)
    means[received.heard] = received.mean_estimates()
    counts = np.isfinite(means)
    count = edges.sum(counts.astype(np.float64))
    total = edges.sum(np.where(counts, means, 0.0))
    return np.where(count > 0, total / np.maximum(count, 1.0), np.nan)


def _replaced(values: Array, positions: Ints, new: Array) -> Array:
    """The values with the `new` ones at `positions`: a copy, or one of both arrays where that is the result."""
    if not new.size:
        return values
    if len(positions) == len(values):
        return new
    result = values.copy()
    result[positions] = new
    return result


def _shared(values: Array, positions: Ints, new: Array) -> Array:
    """As `_replaced`, for values [m, q]. A sender with another number of values has another law: its values are 0."""
    if not values.shape[1]:
        return values
    fits = new.shape[1] == values.shape[1]
    return _replaced(values, positions, new if fits else np.zeros((len(new), values.shape[1]), values.dtype))


def _carried(contacts: Contacts, edges: Edges) -> Contacts:
    """The contacts over `edges`; a new one has heard no beacon yet."""
    if edges is contacts.edges:
        return contacts
    carry = edges.after(contacts.edges).carry
    return Contacts(
        edges,
        heard=carry(contacts.heard, NEVER),
        x=carry(contacts.x, 0.0),
        y=carry(contacts.y, 0.0),
        heading=carry(contacts.heading, 0.0),
        estimates=carry(contacts.estimates, np.nan),
        selected_by_peer=carry(contacts.selected_by_peer, False),
        statistics=carry(contacts.statistics, 0.0),
        declared=carry(contacts.declared, 0),
        heard_separation=carry(contacts.heard_separation, 0.0),
        known=carry(contacts.known, False),
        dx=carry(contacts.dx, 0.0),
        dy=carry(contacts.dy, 0.0),
        separation=carry(contacts.separation, 0.0),
    )
