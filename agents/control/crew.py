"""A crew of one or more robots: pure functions of arrays with a leading robot axis.

`step` is the table of contents of a robot. The code and the digits are the same whether a process hosts one robot or
all robots.
"""

from functools import partial

import numpy as np

from agents.control import clocks, contacts, links, localization, motion, separation, transmitter
from agents.control.links import Links
from agents.control.state import Crew, CrewState
from fes.arrays import geometry
from fes.arrays.types import Bools, Floats, Ints
from fes.errors import FesError
from fes.extension import crew_laws
from fes.extension.context import Draws, LawContext, SeededDraws
from fes.extension.neighborhood import Entry, Neighborhood
from fes.extension.protocols import Formed, Published
from fes.model import counts, stability
from fes.model.config import AgentConfig
from fes.model.contacts import Contacts
from fes.model.sensing import MAX_NUMBER, OPENING_TICKS, Beacons, Received, Sensed, Telemetry, bounded
from fes.model.table import Use

FIRST_EXCHANGE_TICKS = 2
"""Ticks from a robot's first link until it has heard which peers selected it. Then its initial graph is complete."""


def create(config: AgentConfig, ids: Ints, draws: Draws | None = None) -> Crew:
    """The crew of robots `ids` [n], ascending, of a run with `config`; raises FesError for settings out of bounds.

    Random numbers come from `draws`, by default from the seed of `config`.
    """
    try:
        stability.check(config.dt, config.seeking, config.formation, config.objective)
    except ValueError as error:
        raise FesError(f"the run's settings: {error}") from None
    numbers = SeededDraws(config.seed) if draws is None else draws
    emulated = clocks.of(config, ids, numbers)
    dither = None if isinstance(config.seeking, Use) else config.seeking.common_dither
    skew = partial(clocks.skew, emulated)
    context = LawContext(ids, config.dt, config.objective, numbers, skew, dither=dither)
    laws = crew_laws.laws(config, context)
    estimates = getattr(laws.seeking, "estimates", None)
    timeout = counts.ticks_within(config.formation.contact_timeout, config.dt)
    transmitters, localizer = transmitter.of(config, ids), localization.of(config)
    return Crew(config, ids, *laws, estimates, timeout, emulated, transmitters, localizer)


def start(crew: Crew) -> CrewState:
    """The state of a crew that has sensed and heard nothing yet."""
    n, never = len(crew.ids), np.full(len(crew.ids), np.iinfo(np.int64).max // 2)
    formed, sought = crew.formation.start(), crew.seeking.start()
    none = contacts.no_contacts(crew.ids, crew.seeking.statistics, crew.formation.declared + crew.seeking.declared)
    known_links, located = links.no_links(crew.ids), localization.start(n)
    return CrewState(np.zeros((n, 3)), none, known_links, formed, sought, never, never, {}, located)


def forget(crew: Crew, state: CrewState, restarted: Bools) -> CrewState:
    """The state in which the robots `restarted` [n] know nothing, as if their process had just started."""
    blank = start(crew)
    remaining = links.forget(state.links, state.contacts, restarted)
    return CrewState(
        np.where(restarted[:, None], blank.poses, state.poses),
        contacts.forget(state.contacts, restarted),
        remaining,
        crew.formation.forget(state.formation, restarted),
        crew.seeking.forget(state.seeking, restarted, state.links.edges, remaining.edges),
        np.where(restarted, blank.linked_since, state.linked_since),
        np.where(restarted, blank.since, state.since),
        transmitter.forget(state.unsent, restarted),
        localization.forget(state.located, restarted),
    )


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # settings may be extreme; twists are checked
def step(
    crew: Crew, state: CrewState, sensed: Sensed, received: Received
) -> tuple[CrewState, Beacons, Floats, Telemetry]:
    """One tick: from what the robots sense at this tick, and the beacons received of the previous one.

    Returns the next state, the beacons that are transmitted at this tick, the twists [n, 2] [m/s, rad/s], and the
    telemetry. Raises FesError for a twist that is not finite.
    """
    located = localization.locate(crew.localizer, state.located, sensed)
    sensed, since = localization.sensed(crew.localizer, located), np.minimum(state.since, sensed.tick)
    known = contacts.update(state.contacts, received, state.poses, crew.contact_timeout)
    selected = crew.rule(known)
    used = links.among(state.links, state.contacts, known, selected | (known.selected_by_peer & known.known))
    linked_since, sought = _relink(crew, state, used, sensed.tick, since, received)
    around = Neighborhood(sensed.tick, crew.config.dt, sensed.poses, known, state.contacts, used.edges, used.contact)
    desired = crew.seeking.desired(sought, sensed.tick, used.edges)
    without_dither = crew.estimates(sought, used.edges) if crew.estimates else None
    formed = crew.formation.step(state.formation, around, links.geometry(known, used, desired, without_dither))
    around = around._replace(quality_weight=formed.quality_weight)
    twists = _twists(crew, formed, sensed, known, since)
    sought = crew.seeking.measure(sought, around, formed)
    published = crew.seeking.publish(sought, used.edges)
    beacons = _beacons(sensed, used, selected, published, formed)
    telemetry = _telemetry(beacons, published, formed)
    beacons, unsent = transmitter.send(crew.transmitters, state.unsent, beacons)
    sought = crew.seeking.seek(sought, around)
    located = localization.command(located, twists)
    after = CrewState(sensed.poses, known, used, formed.state, sought, linked_since, since, unsent, located)
    return after, beacons, twists, telemetry


def _twists(crew: Crew, formed: Formed, sensed: Sensed, known: Contacts, since: Ints) -> Floats:
    """The twists [n, 2] that follow the pull, and keep the safe separation if the robots have one."""
    dt, config = crew.config.dt, crew.config.formation
    peers = separation.near(known, sensed, dt, config)
    free = motion.twists(crew.ids, separation.give_way(formed, peers, config), sensed, dt, config)
    is_new = sensed.tick - since < OPENING_TICKS
    return separation.slow_down(free, peers, sensed.poses[:, geometry.HEADING], is_new, dt, config)


def _relink(
    crew: Crew, state: CrewState, used: Links, tick: int, since: Ints, received: Received
) -> tuple[Ints, object]:
    """The tick of each robot's first link [n], and the seeking state over the links `used`."""
    old, edges = state.links.edges, used.edges
    if edges is old:
        return state.linked_since, state.seeking
    linked_since = np.where(edges.counts > 0, np.minimum(state.linked_since, tick), state.linked_since)
    is_fresh = tick - linked_since < FIRST_EXCHANGE_TICKS
    is_late = is_fresh & (since > 0)  # at the start of a run the peers' estimates are draws too
    reported = np.full(len(is_late), np.nan)
    if is_late.any():
        reported = np.where(is_late, contacts.mean_estimates(received.edges, received), np.nan)
    return linked_since, crew.seeking.relink(state.seeking, old, edges, Entry(tick, is_fresh, reported))


def _beacons(sensed: Sensed, used: Links, selected: Bools, published: Published, formed: Formed) -> Beacons:
    """The beacons that the robots hand to their transmitters."""
    parts = [part for part in (formed.declared, published.declared) if part is not None]
    return Beacons(
        sensed.tick,
        used.edges.ids,
        bounded(sensed.poses, MAX_NUMBER),
        used.edges,
        bounded(published.estimates, MAX_NUMBER),
        selected.take(used.contact),
        bounded(published.statistics, MAX_NUMBER),
        np.concatenate(parts, axis=1) if parts else np.zeros((len(sensed.poses), 0), dtype=np.uint8),
    )


def _telemetry(beacons: Beacons, published: Published, formed: Formed) -> Telemetry:
    """The numbers for observers, beside the robots' `beacons`."""
    details = np.zeros((len(beacons.ids), 0)) if formed.details is None else bounded(formed.details, MAX_NUMBER)
    return Telemetry(beacons.links, beacons.estimates, bounded(published.learnt, MAX_NUMBER), details)
