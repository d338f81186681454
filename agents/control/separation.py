"""Safe separation: a filter that keeps robots apart, between the formation law and the bodies.

A robot at distance d of a peer may close at half of gamma (d - d_safe), toward every place where the peer can be now.
If both robots keep to this, d - d_safe shrinks per tick at most by the factor 1 - gamma dt.
docs/explanation/safe-separation.md has the conditions and the proof.

1. `give_way` clips the pull to the largest speed, and adds a part to the right of each near peer that it approaches.
2. `give_way` then removes, peer by peer, the part of the pull that would close too fast.
3. `slow_down` bounds the linear speed of every twist, also of twists that a law returns.
"""

import math
from typing import NamedTuple

import numpy as np

from fes.arithmetic import elementary
from fes.arrays import geometry
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats
from fes.extension.protocols import Formed
from fes.model.config import FormationConfig
from fes.model.contacts import Contacts
from fes.model.sensing import Sensed

SWEEPS = 3
"""Passes over the near peers in step 2: each peer's part disturbs the ones before it."""


class Near(NamedTuple):
    """The known peers that are near enough to bound the motion of a robot; p pairs (robot, peer)."""

    edges: Edges
    x: Floats
    y: Floats
    """Unit vector to the place where the peer was last heard [p; world frame]."""
    bound: Floats
    """Largest closing speed [p] [m/s] (b_j)."""
    spread: Floats
    """Sine of the half-angle under which the robot sees all places where the peer can be [p] [1] (s_j)."""


def near(contacts: Contacts, sensed: Sensed, dt: float, config: FormationConfig) -> Near | None:
    """The near peers, from the own poses sensed at this tick; None if the robots keep no safe separation.

    A place that was heard tau ticks ago is that of the peer now, up to v_max tau h.
    """
    if config.safe_separation is None or config.linear_limit is None:
        return None
    edges, limit = contacts.edges, config.linear_limit
    dx = contacts.x - sensed.poses[:, geometry.X].take(edges.rows)
    dy = contacts.y - sensed.poses[:, geometry.Y].take(edges.rows)
    distance = geometry.separation(dx, dy)
    reach = limit * dt * (sensed.tick - contacts.heard).astype(np.float64)
    safe: Floats | float = config.safe_separation
    if sensed.deviation is not None:  # of both ends: the peer has the same sensor
        safe = safe + math.sqrt(2.0) * sensed.deviation.take(edges.rows)
    room = distance - safe - reach
    # Farther away, the bound is at least the largest speed.
    is_near = contacts.known & (0.5 * config.separation_gain * room < limit)
    pairs = edges.select(is_near)
    dx, dy, distance, reach, room = (values[is_near] for values in (dx, dy, distance, reach, room))
    is_apart = distance > 0.0  # where two robots coincide, the lower id looks along +x
    size = np.where(is_apart, distance, 1.0)
    return Near(
        pairs,
        np.where(is_apart, dx / size, np.sign(pairs.peers - pairs.robots)),
        np.where(is_apart, dy / size, 0.0),
        np.maximum(0.5 * config.separation_gain * room, 0.0),
        np.where(reach < distance, reach / size, 1.0),
    )


def give_way(formed: Formed, peers: Near | None, config: FormationConfig) -> Formed:
    """The law's result with a pull that keeps the robots apart: steps 1 and 2."""
    if peers is None or config.linear_limit is None:
        return formed
    longest = config.linear_limit / config.linear_gain
    pull = _clipped(formed.pull, longest)
    if len(peers.edges):
        yielded = _clipped(_yielding(_turned(pull, peers, config), peers, config), longest)
        # A robot without a near peer keeps its pull: its digits must not depend on the other robots of its process.
        pull = np.where((peers.edges.counts > 0)[:, None], yielded, pull)
    return formed._replace(pull=pull)


def slow_down(
    twists: Floats, peers: Near | None, heading: Floats, is_new: Bools, dt: float, config: FormationConfig
) -> Floats:
    """The twists [n, 2] with linear speeds that keep the robots apart: step 3.

    `heading` [n] [rad] is that of the tick's beginning. A robot moves along its mean heading, and backward if it
    turns by more than a full turn. A robot that `is_new` [n] cannot have heard a peer yet, and does not drive.
    """
    if peers is None:
        return twists
    result = twists.copy()
    speed = np.where(is_new, 0.0, twists[:, geometry.LINEAR])
    if len(peers.edges):
        half_turn = 0.5 * dt * twists[:, geometry.ANGULAR]
        sine, cosine = elementary.sin_cos(np.stack([heading + half_turn, half_turn]))
        sense = np.sign(speed) * np.where(sine[1] * half_turn < 0.0, -1.0, 1.0)
        bounds = _speed_bounds(sense * cosine[0], sense * sine[0], peers)
        # Processors differ in the sign of the smaller of two zeros.
        speed = np.where(bounds == 0.0, 0.0, np.minimum(np.maximum(speed, -bounds), bounds))
    result[:, geometry.LINEAR] = speed
    return result


def _clipped(pull: Floats, longest: float) -> Floats:
    """Vectors [n, 2], none longer than `longest` [m]."""
    size = geometry.separation(pull[:, 0], pull[:, 1])
    is_long = size > longest
    if not is_long.any():
        return pull
    scale = np.where(is_long, longest / np.where(is_long, size, 1.0), 1.0)
    result: Floats = pull * scale[:, None]
    return result


def _turned(pull: Floats, peers: Near, config: FormationConfig) -> Floats:
    """Step 1: the pull [n, 2] with a part to the right of each peer toward which it would close too fast.

    Two robots that both yield to the right pass each other; without it, they would stop face to face.
    """
    edges, gain = peers.edges, config.linear_gain
    closing = gain * (pull[:, 0].take(edges.rows) * peers.x + pull[:, 1].take(edges.rows) * peers.y)
    part = config.give_way_gain * np.maximum(closing - peers.bound, 0.0) / gain
    return np.stack([pull[:, 0] + edges.sum(part * peers.y), pull[:, 1] - edges.sum(part * peers.x)], axis=1)


def _yielding(pull: Floats, peers: Near, config: FormationConfig) -> Floats:
    """Step 2: the pull [n, 2] without the parts that would close too fast, peer by peer in the order of their ids."""
    edges, gain = peers.edges, config.linear_gain
    x, y = pull[:, 0].copy(), pull[:, 1].copy()
    places = [np.flatnonzero(edges.ranks == rank) for rank in range(int(edges.counts.max()))]
    ranked = [(edges.rows[place], *(values[place] for values in peers[1:])) for place in places]
    for _ in range(SWEEPS):
        for rows, toward_x, toward_y, bound, spread in ranked:  # at most one peer of each robot
            own_x, own_y = x[rows], y[rows]
            closing = own_x * toward_x + own_y * toward_y + spread * geometry.separation(own_x, own_y)
            excess = np.maximum(gain * closing - bound, 0.0) / gain
            x[rows] = own_x - excess * toward_x
            y[rows] = own_y - excess * toward_y
    return np.stack([x, y], axis=1)


def _speed_bounds(x: Floats, y: Floats, peers: Near) -> Floats:
    """Step 3: the largest speed of each robot [n] [m/s] that moves along the unit vectors (x, y) [n].

    Of all places where a peer can be, the nearest one to the direction of motion bounds the speed. With phi the angle
    between motion and u_j, and s_j = sin sigma, that is |v| cos(max(0, phi - sigma)) <= b_j.
    """
    edges = peers.edges
    own_x, own_y = x.take(edges.rows), y.take(edges.rows)
    ahead = own_x * peers.x + own_y * peers.y
    aside = np.abs(own_x * peers.y - own_y * peers.x)
    narrow = np.sqrt(1.0 - peers.spread * peers.spread)
    cosine = np.where(ahead >= narrow, 1.0, ahead * narrow + aside * peers.spread)
    cosine = np.where(peers.spread < 1.0, cosine, 1.0)  # the peer can be in every direction
    is_bounded = cosine > 0.0
    bound = np.where(is_bounded, peers.bound / np.where(is_bounded, cosine, 1.0), np.inf)
    bounds = np.full(len(edges.ids), np.inf)
    bounds[edges.counts > 0] = np.minimum.reduceat(bound, edges.starts)
    return bounds
