"""The links that robots use: the contacts that the neighbor rule of either end selected."""

from dataclasses import dataclass

import numpy as np

from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats, Ints
from fes.extension.neighborhood import LinkGeometry
from fes.model.contacts import Contacts


@dataclass(frozen=True, eq=False)
class Links:
    """The links that the robots use."""

    is_link: Bools
    """True for a contact that is a link [m]."""
    contact: Ints
    """Position of each link among the contacts [l]."""
    edges: Edges


def no_links(ids: Ints) -> Links:
    """No link, and no contact."""
    edges = no_edges(ids)
    return Links(np.zeros(0, dtype=np.bool_), edges.rows, edges)


def among(old: Links, before: Contacts, now: Contacts, is_link: Bools) -> Links:
    """The links among the contacts `now`, those where `is_link` [m]; the `old` ones if they are the same."""
    if now.edges is before.edges and is_link.tobytes() == old.is_link.tobytes():
        return old
    edges = now.edges.select(is_link)
    if edges.keys.tobytes() == old.edges.keys.tobytes():
        edges = old.edges
    return Links(is_link, np.flatnonzero(is_link), edges)


def forget(links: Links, contacts: Contacts, restarted: Bools) -> Links:
    """The links without those of the robots `restarted` [n]; the contacts of these robots are gone too."""
    is_link = links.is_link[~restarted[contacts.edges.rows]]
    return Links(is_link, np.flatnonzero(is_link), links.edges.select(~restarted[links.edges.rows]))


def geometry(contacts: Contacts, links: Links, desired: Floats, without_dither: Floats | None) -> LinkGeometry:
    """The links as the formation law sees them; `desired` [l] [m] are the separations that the seeking law wants.

    `without_dither` [l] [m] are the same without a physical dither; None if there is none.
    """
    separation = contacts.separation.take(links.contact)
    return LinkGeometry(separation, desired, bearing(contacts, links.contact, separation), without_dither)


def bearing(contacts: Contacts, positions: Ints, size: Floats) -> Floats:
    """Unit vectors [2, l] of the lines of sight, of length `size` [l] [m], of the contacts at `positions` [l].

    The paper needs psi_ji = pi + psi_ij even where two robots coincide: there the lower id looks along +x.
    """
    direction = np.empty((2, len(positions)))
    contacts.dx.take(positions, out=direction[0], mode="clip")
    contacts.dy.take(positions, out=direction[1], mode="clip")
    if np.count_nonzero(size) < len(size):
        apart, edges = size > 0.0, contacts.edges
        direction[0] = np.where(apart, direction[0], np.sign(edges.peers - edges.robots).take(positions))
        size = np.where(apart, size, 1.0)
    direction /= size
    return direction
