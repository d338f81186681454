"""The links that robots use: the contacts that either side's graph rule chose."""

from dataclasses import dataclass

import numpy as np

from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.contacts import Contacts


@dataclass(frozen=True, eq=False)
class Links:
    """The links that the robots use, and what they seek on each."""

    among: Bools
    """Which contacts they are [m]."""
    contact: Ints
    """Position of each link among the contacts [l]."""
    edges: Edges
    state: Floats
    """Seeking state [3, l]; rows as in `agents.laws.perturbation`."""
    said: Floats
    """Estimates as in the last beacon [l] [m]."""


def no_links(contacts: Contacts) -> Links:
    """No link among these contacts."""
    nothing = np.zeros(0, dtype=np.int64)
    return Links(contacts.known & False, nothing, no_edges(contacts.edges.ids), np.zeros((3, 0)), np.zeros(0))


def forget(links: Links, who: Bools) -> Links:
    """The links without those of the robots `who` [n]."""
    stays = ~who[links.edges.rows]
    among = links.among.copy()
    among[links.contact[~stays]] = False
    return Links(among, links.contact[stays], links.edges.select(stays), links.state[:, stays], links.said[stays])


def bearing(known: Contacts, at: Ints) -> Floats:
    """Unit vectors [2, l] of the lines of sight of the contacts at positions `at` [l].

    The paper needs psi_ji = pi + psi_ij even where two robots coincide: there the lower id looks along +x.
    """
    size = known.separation.take(at)
    direction = np.empty((2, len(at)))
    known.dx.take(at, out=direction[0], mode="clip")
    known.dy.take(at, out=direction[1], mode="clip")
    if np.count_nonzero(size) < len(size):
        apart, edges = size > 0.0, known.edges
        direction[0] = np.where(apart, direction[0], np.sign(edges.peers - edges.ids[edges.rows]).take(at))
        size = np.where(apart, size, 1.0)
    direction /= size
    return direction
