"""Robots that hear each other at every tick, as their laws see them."""

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats
from fes.extension.context import LawContext, SeededDraws
from fes.extension.neighborhood import LinkGeometry, Neighborhood
from fes.extension.told_channel import ToldChannel
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.contacts import Contacts

DT = 0.02


def context(n: int, channel: ChannelConfig | None = None) -> LawContext:
    """The context of a law of `n` robots with exact clocks."""
    told = None if channel is None else ToldChannel(channel)
    return LawContext(np.arange(n), DT, ObjectiveConfig(), SeededDraws(1), lambda tick, links: np.zeros(1), told)


def everyone(n: int) -> Edges:
    """Each of `n` robots with all others as peers."""
    robots, peers = np.nonzero(~np.eye(n, dtype=np.bool_))
    return Edges(np.arange(n), robots, peers)


def around(
    positions: Floats,
    tick: int = 10,
    heard: Bools | None = None,
    declared: bytes = b"",
    estimates: Floats | None = None,
) -> Neighborhood:
    """All robots at `positions` [n, 2] [m], each with a link to all others.

    A contact whose last beacon is not `heard` [m] is a tick older. Each robot declared its part of `declared`.
    """
    n = len(positions)
    edges = everyone(n)
    poses = np.column_stack([positions, np.zeros(n)])
    dx, dy = (positions[edges.peers] - positions[edges.rows]).T
    separation = np.sqrt(dx * dx + dy * dy)
    m = len(edges)
    fresh = np.ones(m, dtype=np.bool_) if heard is None else heard
    contacts = Contacts(
        edges,
        heard=np.where(fresh, tick - 1, tick - 2),
        x=positions[edges.peers, 0],
        y=positions[edges.peers, 1],
        heading=np.zeros(m),
        estimates=np.full(m, np.nan) if estimates is None else estimates,
        selected_by_peer=np.ones(m, dtype=np.bool_),
        statistics=np.zeros((m, 0)),
        declared=np.frombuffer(declared, dtype=np.uint8).reshape(n, -1)[edges.peers],
        heard_separation=separation,
        known=np.ones(m, dtype=np.bool_),
        dx=dx,
        dy=dy,
        separation=separation,
    )
    return Neighborhood(tick, DT, poses, contacts, contacts, edges, np.arange(m))


def geometry(seen: Neighborhood, desired: float) -> LinkGeometry:
    """The links of a neighborhood, each with the same desired separation [m]."""
    contacts = seen.contacts
    bearing = np.stack([contacts.dx, contacts.dy]) / contacts.separation
    return LinkGeometry(contacts.separation, np.full(len(seen.links), desired), bearing)


def pair(separation: float) -> Floats:
    """Two robots on the x axis [2, 2] [m]."""
    return np.array([[0.0, 0.0], [separation, 0.0]])
