"""The seeking part of a step: each index of `seeking.index` with the law that climbs it."""

import numpy as np

from agents.control import beacon_counting, clocks
from agents.control.links import Links
from agents.control.state import Crew, CrewState
from agents.laws import packet_counting, perturbation
from agents.laws.packet_counting import ReceptionFit
from agents.laws.perturbation import ESTIMATE, Index
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.model.config import SeekingConfig
from fes.model.contacts import Contacts
from fes.model.sensing import Beacons


def learns_by_link(config: SeekingConfig) -> bool:
    """True if each link end learns on its own, from the beacons of that link only."""
    return config.index == "measured" and config.pooling == "none"


def learners(config: SeekingConfig, edges: Edges) -> Ints:
    """Row of the learner of each link [l]: the link end itself, or its robot."""
    return np.arange(len(edges)) if learns_by_link(config) else edges.rows


def stagger(crew: Crew, edges: Edges) -> Floats:
    """Time by which the dither of each link is ahead of the common one [l] [s]; 0 where robots pool samples."""
    if not learns_by_link(crew.config.seeking):
        return np.zeros(len(edges))
    return perturbation.stagger(crew.seeker, crew.draws, edges)


def desired(crew: Crew, tick: int, links: Links) -> Floats:
    """The separations to which the robots drive their links [l] [m]. A physical dither makes them oscillate."""
    estimates: Floats = links.state[ESTIMATE]
    if crew.config.seeking.index == "oracle":
        return estimates
    time = tick * crew.config.dt + clocks.skew(crew.clocks, tick, links.edges)
    if learns_by_link(crew.config.seeking):
        time = time + links.stagger
    return estimates + perturbation.dither(crew.seeker, time)


def measure(
    crew: Crew, state: CrewState, tick: int, contacts: Contacts, links: Links, heard: Beacons
) -> ReceptionFit:
    """The fit of the channel after the beacons of the previous tick; unchanged unless the index is measured."""
    config, reception = crew.config.seeking, state.reception
    if config.index != "measured":
        return reception
    positions, separation, decoded = beacon_counting.slots(state.contacts, contacts, tick, links.is_link)
    if learns_by_link(config):
        reception = packet_counting.carry(reception, state.links.edges, links.edges)
        rows = np.searchsorted(links.contact, positions)
    else:
        statistics = np.zeros((len(contacts.edges), packet_counting.STATISTICS))
        if heard.statistics.shape[1] == packet_counting.STATISTICS:
            statistics = heard.statistics.take(contacts.lookup.sender, axis=0)
        reception = packet_counting.mix(reception, contacts.edges, contacts.heard == tick - 1, statistics)
        rows = contacts.edges.rows[positions]
    reception = packet_counting.fade(reception, crew.config.dt)
    return packet_counting.learn(reception, rows, separation, decoded, config.reference_separation)


def seek(crew: Crew, tick: int, contacts: Contacts, links: Links, reception: ReceptionFit) -> Floats:
    """The seeking state [3, l] one tick later."""
    config, peer_estimates = crew.config, contacts.estimates.take(links.contact)
    if config.seeking.index == "measured":
        return _climb_fit(crew, links, reception, peer_estimates)
    age = config.dt * (tick - contacts.heard.take(links.contact)).astype(np.float64)
    peer_estimates = perturbation.extrapolate(crew.seeker, links.state, peer_estimates, age)
    index = None
    if config.seeking.index == "sampled":
        index = _constant(beacon_counting.sample(contacts, tick, links.contact, config.objective))
    skew = clocks.skew(crew.clocks, tick, links.edges)
    return perturbation.advance(crew.seeker, tick, links.state, peer_estimates, skew, index)


def _climb_fit(crew: Crew, links: Links, reception: ReceptionFit, peer_estimates: Floats) -> Floats:
    """The seeking state [3, l] one tick later, by the slope of ln J of the fit, and consensus with the peers."""
    config, estimates = crew.config, links.state[ESTIMATE]
    rows, scale = learners(config.seeking, links.edges), config.seeking.reference_separation
    speed = packet_counting.drift(reception, rows, estimates, config.objective, scale)
    difference = np.where(np.isfinite(peer_estimates), peer_estimates - estimates, 0.0)
    speed += config.seeking.consensus_gain * difference
    state = links.state.copy()
    state[ESTIMATE] = packet_counting.bounded(estimates + config.dt * speed, config.objective)
    return state


def _constant(sample: Floats) -> Index:
    """An index that has the same `sample` [l] at every separation: a tick gives only one."""
    return lambda separation: np.broadcast_to(sample, separation.shape).copy()
