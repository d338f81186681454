"""A crew of one or more robots: pure functions of arrays with a leading robot axis.

`step` is the table of contents of a robot. The same code, and the same digits, whether a process hosts one
robot or all of them.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from agents.control import beacon_counting, clocks, contacts, links, transmitter
from agents.control.clocks import Clocks
from agents.control.links import Links
from agents.control.transmitter import Memory, Transmitters
from agents.laws import formation, neighbor_rules, packet_counting, perturbation
from agents.laws.neighbor_rules import Witnesses
from agents.laws.packet_counting import Reception
from agents.laws.perturbation import Index, Seeker
from fes.arrays import geometry
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.errors import FesError
from fes.model import counts, objective, stability
from fes.model.config import AgentConfig
from fes.model.contacts import Contacts
from fes.model.sensing import MAX_TOLD, MAX_TWIST, Beacons, Observations, Telemetry, bounded

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
    clocks: Clocks
    transmitters: Transmitters


@dataclass(frozen=True, eq=False)
class CrewState:
    """What a crew carries from tick to tick."""

    poses: Floats
    """Own poses at the previous tick [n, 3]."""
    contacts: Contacts
    witnesses: Witnesses
    links: Links
    reception: Reception
    linked_since: Ints
    """Tick of each robot's first link [n]; a large number before."""
    since: Ints
    """Tick of each robot's first step [n]; a large number before."""
    unsent: Memory
    """What late transmitters have still to send."""


def create(config: AgentConfig, ids: Ints) -> Crew:
    """The crew of robots `ids` [n], ascending, of a run with `config`; raises FesError for settings out of bounds."""
    try:
        stability.check(config.dt, config.seeking, config.formation)
    except ValueError as error:
        raise FesError(f"the run's settings: {error}") from None
    seeker = Seeker(config.seeking, _index(config), config.dt)
    pooled = config.seeking.index == "measured" and config.seeking.pooling == "network"
    statistics = packet_counting.SUMS if pooled else 0
    timeout = counts.ticks_within(config.formation.contact_timeout, config.dt)
    return Crew(config, ids, seeker, timeout, statistics, clocks.of(config, ids), transmitter.of(config, ids))


def start(crew: Crew) -> CrewState:
    """The state of a crew that has sensed and heard nothing yet."""
    nobody = contacts.no_contacts(crew.ids)
    never = np.full(len(crew.ids), np.iinfo(np.int64).max // 2)
    known = packet_counting.no_counts(packet_counting.POOLED, len(crew.ids))
    if not _pooled(crew):
        known = packet_counting.no_counts(packet_counting.ALONE, 0)
    none = links.no_links(nobody)
    return CrewState(np.zeros((len(crew.ids), 3)), nobody, Witnesses(nobody.edges), none, known, never, never, {})


def forget(crew: Crew, state: CrewState, who: Bools) -> CrewState:
    """The state in which the robots `who` [n] know nothing, as if their process had just been started."""
    blank = start(crew)
    used = links.forget(state.links, who)
    measured = packet_counting.forget(state.reception, who if _pooled(crew) else who[state.links.edges.rows])
    if not _pooled(crew):
        measured = packet_counting.carry(measured, state.links.edges, used.edges)
    return CrewState(
        np.where(who[:, None], blank.poses, state.poses),
        contacts.forget(state.contacts, who),
        state.witnesses,
        used,
        measured,
        np.where(who, blank.linked_since, state.linked_since),
        np.where(who, blank.since, state.since),
        transmitter.forget(state.unsent, who),
    )


def telemetry(crew: Crew, state: CrewState) -> Telemetry:
    """What the robots have to say of themselves in their last beacons, and have learnt until then."""
    edges = state.links.edges
    learnt = np.zeros((2, 0))
    if crew.config.seeking.index == "measured":
        learners = _learners(crew, edges)
        learnt = np.stack([state.reception.level.take(learners), state.reception.exponent.take(learners)])
    return Telemetry(edges, state.links.said, learnt)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # any settings may occur; twists are checked
def step(
    crew: Crew, state: CrewState, observations: Observations, heard: Beacons
) -> tuple[CrewState, Beacons, Floats]:
    """One tick: from what the robots sense now and heard of the last tick, to what they say and do.

    Returns the next state, the beacons of this tick as they go on the air, and the twists [n, 2] [m/s, rad/s].
    """
    tick, config = observations.tick, crew.config
    begun = np.minimum(state.since, tick)

    # Who is heard, and where
    known = contacts.update(state.contacts, observations, state.poses, heard, crew.contact_timeout)
    witnesses = state.witnesses
    if witnesses.edges is not known.edges:
        witnesses = Witnesses(known.edges, witnesses)

    # Who is a neighbor
    named = neighbor_rules.RULES[config.formation.rule](known, witnesses)
    used, since = _relink(crew, state, tick, known, named | (known.selected_by_peer & known.known), begun, heard)

    # Where to go
    error = known.separation.take(used.contact) - _desired(crew, tick, used)
    pull = formation.formation_vector(used.edges, error, links.bearing(known, used.contact))
    twists = formation.twist(pull, observations.poses[:, geometry.HEADING], config.dt, config.formation)

    if not np.isfinite(twists).all():
        robot = int(crew.ids[~np.isfinite(twists).all(axis=1)][0])
        raise FesError(f"robot {robot} computed a twist that is not finite at tick {tick}: check gains and exponents")
    twists = bounded(twists, MAX_TWIST)

    # What to say, and what to seek until the next tick
    measured = state.reception
    if config.seeking.index == "measured":
        measured = _measure(crew, state, tick, known, used, heard)
    said, statistics = bounded(used.state[perturbation.ESTIMATE], MAX_TOLD), np.zeros((len(crew.ids), 0))
    if crew.statistics:
        statistics = bounded(measured.sums, MAX_TOLD)
    named = named.take(used.contact)
    beacons = Beacons(tick, crew.ids, bounded(observations.poses, MAX_TOLD), used.edges, said, named, statistics)
    beacons, unsent = transmitter.send(crew.transmitters, state.unsent, beacons)
    used = replace(used, state=_seek(crew, tick, known, used, measured), said=said)
    return CrewState(observations.poses, known, witnesses, used, measured, since, begun, unsent), beacons, twists


def _desired(crew: Crew, tick: int, links: Links) -> Floats:
    """The separations that the robots drive their links to [l] [m]: a physical dither makes them breathe."""
    estimates: Floats = links.state[perturbation.ESTIMATE]
    if crew.config.seeking.index == "oracle":
        return estimates
    time = tick * crew.config.dt + clocks.skew(crew.clocks, tick, links.edges)
    if crew.config.seeking.index == "measured" and crew.config.seeking.pooling == "none":
        time = time + perturbation.stagger(crew.seeker, crew.config.seed, links.edges)
    return estimates + perturbation.dither(crew.seeker, time)


def _pooled(crew: Crew) -> bool:
    """Whether robots learn (or nobody does), and not links."""
    return crew.config.seeking.pooling == "network" or crew.config.seeking.index != "measured"


def _learners(crew: Crew, edges: Edges) -> Ints:
    """Who learns of each link: its robot, or itself [l]."""
    return edges.rows if _pooled(crew) else np.arange(len(edges))


def _measure(crew: Crew, state: CrewState, tick: int, known: Contacts, links: Links, heard: Beacons) -> Reception:
    """What the robots know of the channel after the beacons of the last tick."""
    config, before = crew.config.seeking, state.reception
    at, separation, decoded = beacon_counting.slots(state.contacts, known, tick, links.among)
    if config.pooling == "network":
        theirs = np.zeros((len(known.edges), packet_counting.SUMS))
        if heard.statistics.shape[1] == packet_counting.SUMS:
            theirs = heard.statistics.take(known.lookup.sender, axis=0)
        before = packet_counting.mix(before, known.edges, known.heard == tick - 1, theirs)
        learners = known.edges.rows[at]
    else:
        before = packet_counting.carry(before, state.links.edges, links.edges)
        learners = np.searchsorted(links.contact, at)
    before = packet_counting.fade(before, crew.config.dt)
    return packet_counting.learn(before, learners, separation, decoded, config.reference_separation)


def _seek(crew: Crew, tick: int, known: Contacts, links: Links, measured: Reception) -> Floats:
    """The seeking state [3, l] one tick later."""
    config, seen = crew.config, known.estimates.take(links.contact)
    if config.seeking.index == "measured":
        scale, estimates = config.seeking.reference_separation, links.state[perturbation.ESTIMATE]
        speed = packet_counting.drift(measured, _learners(crew, links.edges), estimates, config.objective, scale)
        speed += config.seeking.consensus_gain * np.where(np.isfinite(seen), seen - estimates, 0.0)
        sought = links.state.copy()
        sought[perturbation.ESTIMATE] = packet_counting.bounded(estimates + config.dt * speed, config.objective)
        return sought
    age = config.dt * (tick - known.heard.take(links.contact)).astype(np.float64)
    theirs = perturbation.extrapolate(crew.seeker, links.state, seen, age)
    index = None
    if config.seeking.index == "sampled":
        index = _held(beacon_counting.sample(known, tick, links.contact, config.objective))
    skew = clocks.skew(crew.clocks, tick, links.edges)
    return perturbation.advance(crew.seeker, tick, links.state, theirs, skew, index)


def _held(sample: Floats) -> Index:
    """An index of which only one sample a tick is known [l]."""
    return lambda separation: np.broadcast_to(sample, separation.shape).copy()


def _relink(
    crew: Crew, state: CrewState, tick: int, known: Contacts, among: Bools, begun: Ints, heard: Beacons
) -> tuple[Links, Ints]:
    """The links among the contacts `among` [m] now, and since when each robot has any [n]."""
    old = state.links
    if known.edges is state.contacts.edges and among.tobytes() == old.among.tobytes():
        return old, state.linked_since
    edges = known.edges.select(among)
    since = np.where(edges.counts > 0, np.minimum(state.linked_since, tick), state.linked_since)
    fresh = tick - since < FIRST_EXCHANGE_TICKS
    late = fresh & (begun > 0)  # at the start of a run everybody is new
    told = np.where(late, contacts.mean_estimates(known, heard), np.nan) if late.any() else np.full(len(late), np.nan)
    sought = perturbation.relink(crew.seeker, crew.config.seed, tick, old.edges, old.state, edges, fresh, told)
    return Links(among, np.flatnonzero(among), edges, sought, sought[perturbation.ESTIMATE]), since


def _index(config: AgentConfig) -> Index:
    if config.seeking.index == "measured":
        return np.zeros_like
    if config.seeking.index == "sampled":  # what a link's baseline begins with
        return partial(objective.preference, objective=config.objective)
    if config.channel is None:
        raise FesError("seeking.index = 'oracle' needs the channel, and this agent was not told it")
    # Only here, so that a process of a run with another index never loads the channel's formula.
    from agents.laws import oracle

    return oracle.index(config.objective, config.channel, config.seeking.index_transform)
