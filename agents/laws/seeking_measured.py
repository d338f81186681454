"""The seeking laws that climb ln J along the slope measured by counting beacons: pooled, or each link alone.

The dither is physical: the robots drive to the dithered separations.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from agents.laws import link_estimates, packet_counting
from agents.laws.packet_counting import Method, ReceptionFit
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.extension.context import LawContext
from fes.extension.neighborhood import Entry, Neighborhood
from fes.extension.protocols import Formed, Published
from fes.model.seeking import MeasuredConfig


@dataclass(frozen=True, eq=False)
class Measured:
    """The state of a measured law."""

    estimates: Floats
    """[l] [m]"""
    ahead: Floats
    """Time by which the dither of each link is ahead of the common one [l] [s]."""
    fit: ReceptionFit
    """One learner per robot, or per link."""


class MeasuredSeeking:
    """The common part of both laws; a subclass says who learns from which beacon."""

    Parameters = MeasuredConfig
    knows_channel = False
    statistics = 0
    declared = 0
    learnt = ("level", "exponent")
    method: ClassVar[Method]

    def __init__(self, parameters: MeasuredConfig, context: LawContext) -> None:
        self.config, self.context = parameters, context

    def start(self) -> Measured:
        """No link, and no beacon counted."""
        nothing = np.zeros(0)
        return Measured(nothing, nothing, packet_counting.no_counts(self.method, self.learners()))

    def forget(self, state: Measured, restarted: Bools, old: Edges, new: Edges) -> Measured:
        """The state without the links that are gone, and without the counts of the robots `restarted` [n]."""
        estimates, ahead = new.carry(state.estimates, old, np.nan), new.carry(state.ahead, old, 0.0)
        return Measured(estimates, ahead, self.forget_fit(state.fit, restarted, old, new))

    def relink(self, state: Measured, old: Edges, new: Edges, entry: Entry) -> Measured:
        """The state over the links `new`."""
        transition = new.after(old)
        estimates = transition.carry(state.estimates, np.nan)
        if transition.is_new.any():
            first = link_estimates.of_new_links(self.config, self.context.draws, old, state.estimates, new, entry)
            estimates = np.where(transition.is_new, first, estimates)
        return Measured(estimates, self.ahead(new), self.carry_fit(state.fit, old, new))

    def desired(self, state: Measured, tick: int, links: Edges) -> Floats:
        """The estimates, with the dither of each robot's clock."""
        time = tick * self.context.dt + self.context.skew(tick, links)
        desired: Floats = state.estimates + link_estimates.dither(self.config, time + state.ahead)
        return desired

    def measure(self, state: Measured, around: Neighborhood, formed: Formed) -> Measured:
        """The fit of the channel after the beacons of the previous tick."""
        slots = around.slots
        fit = packet_counting.fade(self.exchange(state.fit, around), self.context.dt)
        rows, scale = self.rows(slots.contact, around), self.config.reference_separation
        return replace(state, fit=packet_counting.learn(fit, rows, slots.separation, slots.decoded, scale))

    def publish(self, state: Measured, links: Edges) -> Published:
        """The estimates, the statistics of the learners, and the fit of each link."""
        rows = self.of_links(links)
        learnt = np.stack([state.fit.level.take(rows), state.fit.exponent.take(rows)])
        return Published(state.estimates, self.shared(state.fit), learnt)

    def seek(self, state: Measured, around: Neighborhood) -> Measured:
        """The estimates after a tick of climbing the fit's slope of ln J, and of consensus with the peers."""
        estimates, scale = state.estimates, self.config.reference_separation
        objective, rows = self.context.objective, self.of_links(around.links)
        speed = packet_counting.drift(state.fit, rows, estimates, objective, scale)
        peers = around.peer_estimates
        speed += self.config.consensus_gain * np.where(np.isfinite(peers), peers - estimates, 0.0)
        return replace(state, estimates=packet_counting.bounded(estimates + self.context.dt * speed, objective))

    def learners(self) -> int:
        """Number of learners before the first link."""
        raise NotImplementedError

    def of_links(self, links: Edges) -> Ints:
        """Row of the learner of each link [l]."""
        raise NotImplementedError

    def rows(self, contact: Ints, around: Neighborhood) -> Ints:
        """Row of the learner of each slot [s], of the contact at this position."""
        raise NotImplementedError

    def ahead(self, links: Edges) -> Floats:
        """Time by which the dither of each link is ahead of the common one [l] [s]."""
        raise NotImplementedError

    def exchange(self, fit: ReceptionFit, around: Neighborhood) -> ReceptionFit:
        """The fit after the peers' statistics arrived."""
        raise NotImplementedError

    def shared(self, fit: ReceptionFit) -> Floats:
        """The statistics in the beacons [n, q]."""
        raise NotImplementedError

    def carry_fit(self, fit: ReceptionFit, old: Edges, new: Edges) -> ReceptionFit:
        """The fit over the links `new`."""
        raise NotImplementedError

    def forget_fit(self, fit: ReceptionFit, restarted: Bools, old: Edges, new: Edges) -> ReceptionFit:
        """The fit without what the robots `restarted` [n] have counted."""
        raise NotImplementedError


class PooledSeeking(MeasuredSeeking):
    """Each robot is a learner, and mixes its counts with those of the robots that it hears."""

    statistics = packet_counting.STATISTICS
    method = packet_counting.POOLED

    def learners(self) -> int:
        """One per robot."""
        return len(self.context.ids)

    def of_links(self, links: Edges) -> Ints:
        """The row of the link's robot [l]."""
        return links.rows

    def rows(self, contact: Ints, around: Neighborhood) -> Ints:
        """The row of the contact's robot [s]."""
        rows: Ints = around.contacts.edges.rows[contact]
        return rows

    def ahead(self, links: Edges) -> Floats:
        """No time: the formation oscillates as a whole [l] [s]."""
        return np.zeros(len(links))

    def exchange(self, fit: ReceptionFit, around: Neighborhood) -> ReceptionFit:
        """The fit, mixed with the statistics that the robots heard at this tick."""
        return packet_counting.mix(fit, around.contacts.edges, around.is_heard, around.contacts.statistics)

    def shared(self, fit: ReceptionFit) -> Floats:
        """The statistics of each robot [n, q]."""
        return fit.statistics

    def carry_fit(self, fit: ReceptionFit, old: Edges, new: Edges) -> ReceptionFit:
        """Unchanged: a link that ends loses nothing."""
        return fit

    def forget_fit(self, fit: ReceptionFit, restarted: Bools, old: Edges, new: Edges) -> ReceptionFit:
        """The fit without what the robots `restarted` [n] have counted."""
        return packet_counting.forget(fit, restarted)


class LinkSeeking(MeasuredSeeking):
    """Each link end is a learner, from the beacons of that link only: better under shadowing."""

    method = packet_counting.ALONE

    def learners(self) -> int:
        """None before the first link."""
        return 0

    def of_links(self, links: Edges) -> Ints:
        """Each link end itself [l]."""
        return np.arange(len(links))

    def rows(self, contact: Ints, around: Neighborhood) -> Ints:
        """The link of each slot [s]."""
        return np.searchsorted(around.link_contact, contact)

    def ahead(self, links: Edges) -> Floats:
        """A time of its own for each link [l] [s]."""
        return link_estimates.stagger(self.config, self.context.draws, links)

    def exchange(self, fit: ReceptionFit, around: Neighborhood) -> ReceptionFit:
        """Unchanged: robots share no counts."""
        return fit

    def shared(self, fit: ReceptionFit) -> Floats:
        """None [n, 0]."""
        return np.zeros((len(self.context.ids), 0))

    def carry_fit(self, fit: ReceptionFit, old: Edges, new: Edges) -> ReceptionFit:
        """The learners of the links `new`."""
        return packet_counting.carry(fit, old, new)

    def forget_fit(self, fit: ReceptionFit, restarted: Bools, old: Edges, new: Edges) -> ReceptionFit:
        """The learners of the links that remain."""
        return packet_counting.carry(fit, old, new)
