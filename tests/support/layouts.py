"""Robots in the plane and the beacons they receive, built pair by pair in plain Python."""

import math
from collections.abc import Iterable

import numpy as np

from agents.control import contacts
from agents.runtime.reception import Receiver
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.contacts import Contacts
from fes.model.sensing import DECODED, LOST, Beacons, Observations

REACH = 150.0
"""[m]"""


def poses(positions: Iterable[tuple[float, float]], heading: float = 0.0) -> Floats:
    """Poses [n, 3] at `positions`."""
    return np.array([(x, y, heading) for x, y in positions])


def scatter(rng: np.random.Generator, n: int, width: float) -> Floats:
    """n poses, uniform in a square [m]."""
    return np.column_stack([rng.uniform(0.0, width, (n, 2)), rng.uniform(-math.pi, math.pi, n)])


def distance(where: Floats, i: int, j: int) -> float:
    """Between robots i and j [m]."""
    dx, dy = where[i, 0] - where[j, 0], where[i, 1] - where[j, 1]
    return math.sqrt(dx * dx + dy * dy)


def edges(ids: Iterable[int], pairs: Iterable[tuple[int, int]]) -> Edges:
    """The directed `pairs` (robot, peer) of the robots `ids`."""
    crew = sorted(ids)
    ordered = sorted(pairs)
    rows = np.array([crew.index(robot) for robot, _ in ordered], dtype=np.int64)
    return Edges(np.array(crew, dtype=np.int64), rows, np.array([peer for _, peer in ordered], dtype=np.int64))


def in_range(where: Floats, robots: Iterable[int], reach: float = REACH) -> Edges:
    """Peers within reach of each of `robots`, all poses being `where` [n, 3]."""
    crew = list(robots)
    n = len(where)
    return edges(crew, [(i, j) for i in crew for j in range(n) if i != j and distance(where, i, j) <= reach])


def hear(where: Floats, robots: Iterable[int], reach: float = REACH, decoded: Bools | None = None) -> Contacts:
    """The contacts of `robots` after one beacon from every robot; `decoded` [m] marks decoded ones (default: all)."""
    crew = sorted(robots)
    near = in_range(where, crew, reach)
    everybody = np.arange(len(where))
    beacons = silent_beacons(0, everybody, where)
    codes = np.full(len(near), DECODED, dtype=np.uint8)
    if decoded is not None:
        codes[~decoded] = LOST
    own = where[np.array(crew)]
    before = contacts.no_contacts(near.ids, 0, 0)
    return heard(before, Receiver(), Observations(1, own, near, codes), own, beacons)


def heard(
    before: Contacts, receiver: Receiver, sensed: Observations, own: Floats, beacons: Beacons, timeout: int = 50
) -> Contacts:
    """The contacts after the `beacons` that decoded; the robots sent theirs from `own` [n, 3]."""
    return contacts.update(before, receiver.receive(sensed, beacons, before.edges), own, timeout)


def silent_beacons(tick: int, ids: Ints, where: Floats) -> Beacons:
    """Beacons of robots that have no links and measure nothing."""
    nothing, no = np.zeros(0), np.zeros(0, dtype=np.bool_)
    blank = np.zeros((len(ids), 0)), np.zeros((len(ids), 0), dtype=np.uint8)
    return Beacons(tick, ids, where, no_edges(ids), nothing, no, *blank)


def pairs_of(among: Edges, chosen: Bools | None = None) -> set[tuple[int, int]]:
    """The (chosen) pairs (robot, peer)."""
    robots: Ints = among.ids[among.rows]
    mask = np.ones(len(among), dtype=np.bool_) if chosen is None else chosen
    return set(zip(robots[mask].tolist(), among.peers[mask].tolist(), strict=True))
