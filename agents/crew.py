"""A crew of one or more robots: pure functions of arrays with a leading robot axis.

`step` is the table of contents of a robot. The same code, and the same digits, whether a process hosts one
robot or all of them.
"""

import math
from dataclasses import dataclass

import numpy as np

from agents import contacts, formation, neighbors, reception, seeking
from agents.contacts import Contacts
from agents.neighbors import Witnesses
from agents.reception import Reception
from agents.seeking import Index, Seeker
from fes import geometry
from fes.arrays import Bools, Floats, Ints
from fes.config import AgentConfig
from fes.edges import Edges, no_edges
from fes.errors import FesError
from fes.sensing import Beacons, Observations

FIRST_EXCHANGE_TICKS = 2
"""Ticks from a robot's first link until it has heard whether others chose it: its initial graph."""


@dataclass(frozen=True)
class Crew:
    """What does not change during a run."""

    config: AgentConfig
    ids: Ints
    """Robot ids, ascending [n]."""
    seeker: Seeker
    contact_timeout: int
    """[ticks]"""
    statistics: int
    """Numbers that a beacon carries of what was measured."""


@dataclass(frozen=True, eq=False)
class Links:
    """The links that the robots use, and what they seek on each."""

    among: Bools
    """Which contacts they are [m]."""
    contact: Ints
    """Position of each link among the contacts [l]."""
    edges: Edges
    state: Floats
    """Seeking state [3, l]; rows as in `agents.seeking`."""


@dataclass(frozen=True, eq=False)
class State:
    """What a crew carries from tick to tick."""

    poses: Floats
    """Own poses at the previous tick [n, 3]."""
    contacts: Contacts
    witnesses: Witnesses
    links: Links
    reception: Reception
    linked_since: Ints
    """Tick of each robot's first link [n]; a large number before."""


def assemble(config: AgentConfig, ids: Ints) -> Crew:
    """The crew of robots `ids` [n], ascending, of a run with `config`."""
    seeker = Seeker(config.seeking, _index(config), config.dt)
    statistics = reception.SUMS if config.seeking.index == "measured" else 0
    return Crew(config, ids, seeker, math.ceil(config.formation.contact_timeout / config.dt), statistics)


def start(crew: Crew) -> State:
    """The state of a crew that has sensed and heard nothing yet."""
    nobody = contacts.nobody(crew.ids)
    links = Links(nobody.known, np.zeros(0, dtype=np.int64), no_edges(crew.ids), np.zeros((3, 0)))
    never = np.full(len(crew.ids), np.iinfo(np.int64).max // 2)
    return State(
        np.zeros((len(crew.ids), 3)), nobody, Witnesses(nobody.edges), links, reception.nothing(len(crew.ids)), never
    )


def step(crew: Crew, state: State, observations: Observations, heard: Beacons) -> tuple[State, Beacons, Floats]:
    """One tick: from what the robots sense now and heard of the last tick, to what they say and do.

    Returns the next state, the beacons of this tick, and the twists [n, 2] [m/s, rad/s].
    """
    tick, config = observations.tick, crew.config

    # Who is heard, and where
    known = contacts.update(state.contacts, observations, state.poses, heard, crew.contact_timeout)
    witnesses = state.witnesses
    if witnesses.edges is not known.edges:
        witnesses = Witnesses(known.edges, witnesses)

    # Who is a neighbor
    named = neighbors.RULES[config.formation.rule](known, witnesses)
    links, since = _relink(crew, state, tick, known, named | (known.names_us & known.known))

    # Where to go
    error = known.separation.take(links.contact) - _desired(crew, tick, links)
    pull = formation.pull(links.edges, error, _bearing(known, links.contact))
    twists = formation.twist(pull, observations.poses[:, geometry.HEADING], config.dt, config.formation)

    if not np.isfinite(twists).all():
        robot = int(crew.ids[~np.isfinite(twists).all(axis=1)][0])
        raise FesError(f"robot {robot} computed a twist that is not finite at tick {tick}: check gains and exponents")

    # What to say, and what to seek until the next tick
    measured = state.reception
    if config.seeking.index == "measured":
        measured = _measure(crew, state, tick, known, links, heard)
    said, statistics = links.state[seeking.ESTIMATE], measured.sums[:, : crew.statistics]
    named = named.take(links.contact)
    beacons = Beacons(tick, crew.ids, observations.poses, links.edges, said, named, statistics)
    links = Links(links.among, links.contact, links.edges, _seek(crew, tick, known, links, measured))
    return State(observations.poses, known, witnesses, links, measured, since), beacons, twists


def _desired(crew: Crew, tick: int, links: Links) -> Floats:
    """The separations that the robots drive their links to [l] [m]: a physical dither makes them breathe."""
    estimates: Floats = links.state[seeking.ESTIMATE]
    if crew.config.seeking.index != "measured":
        return estimates
    return estimates + seeking.dither(crew.seeker, np.array([tick * crew.config.dt]))


def _measure(crew: Crew, state: State, tick: int, known: Contacts, links: Links, heard: Beacons) -> Reception:
    """What the robots know of the channel after the beacons of the last tick."""
    theirs = np.zeros((len(known.edges), reception.SUMS))
    if heard.statistics.shape[1] == reception.SUMS:
        theirs = heard.statistics.take(known.lookup.sender, axis=0)
    mixed = reception.mix(state.reception, known.edges, known.heard == tick - 1, theirs, crew.config.dt)
    rows, separation, decoded = reception.slots(state.contacts, known, tick, links.among)
    return reception.learn(mixed, rows, separation, decoded, crew.config.seeking.reference_separation)


def _seek(crew: Crew, tick: int, known: Contacts, links: Links, measured: Reception) -> Floats:
    """The seeking state [3, l] one tick later."""
    config, seen = crew.config, known.estimates.take(links.contact)
    if config.seeking.index == "measured":
        scale, estimates = config.seeking.reference_separation, links.state[seeking.ESTIMATE]
        speed = reception.drift(measured, links.edges.rows, estimates, config.objective, scale)
        speed += config.seeking.consensus_gain * np.where(np.isfinite(seen), seen - estimates, 0.0)
        sought = links.state.copy()
        sought[seeking.ESTIMATE] = np.clip(estimates + config.dt * speed, *reception.ESTIMATES)
        return sought
    age = config.dt * (tick - known.heard.take(links.contact)).astype(np.float64)
    return seeking.advance(crew.seeker, tick, links.state, seeking.extrapolate(crew.seeker, links.state, seen, age))


def _relink(crew: Crew, state: State, tick: int, known: Contacts, among: Bools) -> tuple[Links, Ints]:
    """The links among the contacts `among` [m] now, and since when each robot has any [n]."""
    old = state.links
    if known.edges is state.contacts.edges and among.tobytes() == old.among.tobytes():
        return old, state.linked_since
    edges = known.edges.select(among)
    since = np.where(edges.counts > 0, np.minimum(state.linked_since, tick), state.linked_since)
    fresh = tick - since < FIRST_EXCHANGE_TICKS
    sought = seeking.relink(crew.seeker, crew.config.seed, tick, old.edges, old.state, edges, fresh)
    return Links(among, np.flatnonzero(among), edges, sought), since


def _bearing(known: Contacts, at: Ints) -> Floats:
    """Unit vectors [2, l] of the lines of sight of the contacts at positions `at`.

    The paper needs psi_ji = pi + psi_ij even where two robots coincide: there the lower id looks along +x.
    """
    size = known.separation.take(at)
    bearing = np.empty((2, len(at)))
    known.dx.take(at, out=bearing[0], mode="clip")
    known.dy.take(at, out=bearing[1], mode="clip")
    if np.count_nonzero(size) < len(size):
        apart, edges = size > 0.0, known.edges
        bearing[0] = np.where(apart, bearing[0], np.sign(edges.peers - edges.ids[edges.rows]).take(at))
        size = np.where(apart, size, 1.0)
    bearing /= size
    return bearing


def _index(config: AgentConfig) -> Index:
    if config.seeking.index == "measured":
        return np.zeros_like
    if config.channel is None:
        raise FesError("seeking.index = 'oracle' needs the channel, and this agent was not told it")
    # Only here, so that a process of a run with another index never loads the channel's formula.
    from agents import oracle

    return oracle.index(config.objective, config.channel, config.seeking.index_transform)
