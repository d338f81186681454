"""A crew of one or more robots: pure functions of arrays with a leading robot axis.

`step` is the table of contents of a robot. The code and the digits are the same whether a process hosts one robot or
all robots.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from agents.control import clocks, contacts, links, seeking, transmitter
from agents.control.links import Links
from agents.control.state import Crew, CrewState
from agents.laws import formation, neighbor_rules, packet_counting, perturbation
from agents.laws.draws import Draws, SeededDraws
from agents.laws.neighbor_rules import Witnesses
from agents.laws.perturbation import ESTIMATE, Entry, Index, Seeker
from fes.arrays import geometry
from fes.arrays.types import Bools, Floats, Ints
from fes.errors import FesError
from fes.model import counts, objective, stability
from fes.model.config import AgentConfig
from fes.model.contacts import Contacts
from fes.model.sensing import MAX_NUMBER, MAX_TWIST, Beacons, Observations, Telemetry, bounded

FIRST_EXCHANGE_TICKS = 2
"""Ticks from a robot's first link until it has heard which peers selected it. Then its initial graph is complete."""


def create(config: AgentConfig, ids: Ints, draws: Draws | None = None) -> Crew:
    """The crew of robots `ids` [n], ascending, of a run with `config`; raises FesError for settings out of bounds.

    Random numbers come from `draws`, by default from the seed of `config`.
    """
    try:
        stability.check(config.dt, config.seeking, config.formation)
    except ValueError as error:
        raise FesError(f"the run's settings: {error}") from None
    pooled = config.seeking.index == "measured" and config.seeking.pooling == "network"
    numbers = SeededDraws(config.seed) if draws is None else draws
    return Crew(
        config,
        ids,
        numbers,
        Seeker(config.seeking, _index(config), config.dt),
        counts.ticks_within(config.formation.contact_timeout, config.dt),
        packet_counting.STATISTICS if pooled else 0,
        clocks.of(config, ids, numbers),
        transmitter.of(config, ids),
    )


def start(crew: Crew) -> CrewState:
    """The state of a crew that has sensed and heard nothing yet."""
    no_contacts = contacts.no_contacts(crew.ids)
    never = np.full(len(crew.ids), np.iinfo(np.int64).max // 2)
    if seeking.learns_by_link(crew.config.seeking):
        reception = packet_counting.no_counts(packet_counting.ALONE, 0)
    else:
        reception = packet_counting.no_counts(packet_counting.POOLED, len(crew.ids))
    return CrewState(
        np.zeros((len(crew.ids), 3)),
        no_contacts,
        Witnesses(no_contacts.edges),
        links.no_links(no_contacts),
        reception,
        never,
        never,
        {},
    )


def forget(crew: Crew, state: CrewState, restarted: Bools) -> CrewState:
    """The state in which the robots `restarted` [n] know nothing, as if their process had just started."""
    blank, edges = start(crew), state.links.edges
    remaining = links.forget(state.links, restarted)
    if seeking.learns_by_link(crew.config.seeking):
        reception = packet_counting.carry(state.reception, edges, remaining.edges)
    else:
        reception = packet_counting.forget(state.reception, restarted)
    return CrewState(
        np.where(restarted[:, None], blank.poses, state.poses),
        contacts.forget(state.contacts, restarted),
        state.witnesses,
        remaining,
        reception,
        np.where(restarted, blank.linked_since, state.linked_since),
        np.where(restarted, blank.since, state.since),
        transmitter.forget(state.unsent, restarted),
    )


def telemetry(crew: Crew, state: CrewState) -> Telemetry:
    """The robots' telemetry: their links and estimates of this tick, and the fits behind them."""
    edges = state.links.edges
    learnt = np.zeros((2, 0))
    if crew.config.seeking.index == "measured":
        rows = seeking.learners(crew.config.seeking, edges)
        learnt = np.stack([state.reception.level.take(rows), state.reception.exponent.take(rows)])
    return Telemetry(edges, state.links.published, learnt)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # settings may be extreme; twists are checked
def step(
    crew: Crew, state: CrewState, observations: Observations, heard: Beacons
) -> tuple[CrewState, Beacons, Floats]:
    """One tick: from the observations of this tick and the beacons of the previous one to new beacons and twists.

    Returns the next state, the beacons that are transmitted at this tick, and the twists [n, 2] [m/s, rad/s]. Raises
    FesError for a twist that is not finite.
    """
    tick, config = observations.tick, crew.config
    since = np.minimum(state.since, tick)

    # Peers heard, and their positions
    known = contacts.update(state.contacts, observations, state.poses, heard, crew.contact_timeout)
    witnesses = state.witnesses
    if witnesses.edges is not known.edges:
        witnesses = Witnesses(known.edges, witnesses)

    # Neighbors
    selected = neighbor_rules.RULES[config.formation.rule](known, witnesses)
    is_link = selected | (known.selected_by_peer & known.known)
    used, linked_since = _relink(crew, state, tick, known, is_link, since, heard)

    # Motion
    error = known.separation.take(used.contact) - seeking.desired(crew, tick, used)
    vector = formation.formation_vector(used.edges, error, links.bearing(known, used.contact))
    twists = formation.twist(vector, observations.poses[:, geometry.HEADING], config.dt, config.formation)
    if not np.isfinite(twists).all():
        robot = int(crew.ids[~np.isfinite(twists).all(axis=1)][0])
        raise FesError(f"robot {robot} computed a twist that is not finite at tick {tick}: check gains and exponents")
    twists = bounded(twists, MAX_TWIST)

    # Beacons, and the estimates until the next tick
    reception = seeking.measure(crew, state, tick, known, used, heard)
    estimates, statistics = bounded(used.state[ESTIMATE], MAX_NUMBER), np.zeros((len(crew.ids), 0))
    if crew.statistics:
        statistics = bounded(reception.statistics, MAX_NUMBER)
    beacons = Beacons(
        tick,
        crew.ids,
        bounded(observations.poses, MAX_NUMBER),
        used.edges,
        estimates,
        selected.take(used.contact),
        statistics,
    )
    beacons, unsent = transmitter.send(crew.transmitters, state.unsent, beacons)
    used = replace(used, state=seeking.seek(crew, tick, known, used, reception), published=estimates)
    after = CrewState(observations.poses, known, witnesses, used, reception, linked_since, since, unsent)
    return after, beacons, twists


def _relink(
    crew: Crew, state: CrewState, tick: int, known: Contacts, is_link: Bools, since: Ints, heard: Beacons
) -> tuple[Links, Ints]:
    """The links among the contacts `is_link` [m] now, and the tick of each robot's first link [n]."""
    old = state.links
    if known.edges is state.contacts.edges and is_link.tobytes() == old.is_link.tobytes():
        return old, state.linked_since
    edges = known.edges.select(is_link)
    linked_since = np.where(edges.counts > 0, np.minimum(state.linked_since, tick), state.linked_since)
    fresh = tick - linked_since < FIRST_EXCHANGE_TICKS
    late = fresh & (since > 0)  # at the start of a run the peers' estimates are draws too
    reported = np.full(len(late), np.nan)
    if late.any():
        reported = np.where(late, contacts.mean_estimates(known, heard), np.nan)
    seeking_state = perturbation.relink(
        crew.seeker, crew.draws, old.edges, old.state, edges, Entry(tick, fresh, reported)
    )
    published, stagger = seeking_state[ESTIMATE], seeking.stagger(crew, edges)
    return Links(is_link, np.flatnonzero(is_link), edges, seeking_state, published, stagger), linked_since


def _index(config: AgentConfig) -> Index:
    """The index that the perturbation law climbs. A measured run uses only the law's dither and its relinking."""
    if config.seeking.index == "measured":
        return np.zeros_like
    if config.seeking.index == "sampled":  # only for the initial baseline of a link
        return partial(objective.preference, objective=config.objective)
    if config.channel is None:
        raise FesError("seeking.index = 'oracle' needs the channel, and this agent did not receive it")
    # Imported here, so that a process of a run with another index never loads the channel's formula.
    from agents.laws import oracle

    return oracle.index(config.objective, config.channel, config.seeking.index_transform)
