"""The links that robots use: the contacts that the neighbor rule of either end selected."""

from dataclasses import dataclass

import numpy as np

from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.contacts import Contacts


@dataclass(frozen=True, eq=False)
class Links:
    """The links that the robots use, and the seeking state of each."""

    is_link: Bools
    """True for a contact that is a link [m]."""
    contact: Ints
    """Position of each link among the contacts [l]."""
    edges: Edges
    state: Floats
    """Seeking state [3, l]; rows as in `agents.laws.perturbation`."""
    published: Floats
    """Estimates as in the last beacon [l] [m]."""
    stagger: Floats
    """Time by which the dither of each link is ahead of the common one [l] [s]."""


def no_links(contacts: Contacts) -> Links:
    """No link among these contacts."""
    edges, nothing = no_edges(contacts.edges.ids), np.zeros(0)
    return Links(contacts.known & False, edges.rows, edges, np.zeros((3, 0)), nothing, nothing)


def forget(links: Links, restarted: Bools) -> Links:
    """The links without those of the robots `restarted` [n]."""
    remains = ~restarted[links.edges.rows]
    is_link = links.is_link.copy()
    is_link[links.contact[~remains]] = False
    return Links(
        is_link,
        links.contact[remains],
        links.edges.select(remains),
        links.state[:, remains],
        links.published[remains],
        links.stagger[remains],
    )


def bearing(contacts: Contacts, positions: Ints) -> Floats:
    """Unit vectors [2, l] of the lines of sight of the contacts at `positions` [l].

    The paper needs psi_ji = pi + psi_ij even where two robots coincide: there the lower id looks along +x.
    """
    size = contacts.separation.take(positions)
    direction = np.empty((2, len(positions)))
    contacts.dx.take(positions, out=direction[0], mode="clip")
    contacts.dy.take(positions, out=direction[1], mode="clip")
    if np.count_nonzero(size) < len(size):
        apart, edges = size > 0.0, contacts.edges
        direction[0] = np.where(apart, direction[0], np.sign(edges.peers - edges.robots).take(positions))
        size = np.where(apart, size, 1.0)
    direction /= size
    return direction
