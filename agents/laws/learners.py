"""The learners of a measured law: one per robot from all its links, or one per link end from that link."""

from typing import Protocol

import numpy as np

from agents.laws import link_estimates, packet_counting
from agents.laws.packet_counting import ReceptionFit
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.extension.context import Draws
from fes.extension.neighborhood import Neighborhood
from fes.model.seeking import LinkSeekingConfig


class Learners(Protocol):
    """The learners of a crew of n robots with l links; each is one row of a fit."""

    @property
    def statistics(self) -> int:
        """Number of statistics in each beacon, q."""

    def start(self) -> ReceptionFit:
        """The fit before the first link: the prior."""

    def of_links(self, links: Edges) -> Ints:
        """Row of the learner of each link [l]."""

    def of_contacts(self, contact: Ints, around: Neighborhood) -> Ints:
        """Row of the learner of each contact at these positions [s]; each has a link."""

    def ahead(self, links: Edges) -> Floats:
        """Time by which the dither of each link is ahead of the common one [l] [s]."""

    def exchange(self, fit: ReceptionFit, around: Neighborhood) -> ReceptionFit:
        """The fit after the peers' statistics arrived."""

    def shared(self, fit: ReceptionFit) -> Floats:
        """The statistics in the beacons [n, q]."""

    def carry(self, fit: ReceptionFit, old: Edges, new: Edges) -> ReceptionFit:
        """The fit over the links `new`, from that over `old`."""

    def forget(self, fit: ReceptionFit, restarted: Bools, old: Edges, new: Edges) -> ReceptionFit:
        """The fit without the counts of the robots `restarted` [n]; the `new` links are those of the others."""


class RobotLearners:
    """Each robot is a learner, and mixes its counts with those of the robots that it hears."""

    statistics = packet_counting.STATISTICS

    def __init__(self, robots: int) -> None:
        self._robots = robots

    def start(self) -> ReceptionFit:
        """One learner per robot."""
        return packet_counting.no_counts(packet_counting.POOLED, self._robots)

    def of_links(self, links: Edges) -> Ints:
        """The row of the link's robot [l]."""
        return links.rows

    def of_contacts(self, contact: Ints, around: Neighborhood) -> Ints:
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

    def carry(self, fit: ReceptionFit, old: Edges, new: Edges) -> ReceptionFit:
        """Unchanged: a link that ends loses nothing."""
        return fit

    def forget(self, fit: ReceptionFit, restarted: Bools, old: Edges, new: Edges) -> ReceptionFit:
        """The robots `restarted` [n] begin with the prior."""
        return packet_counting.forget(fit, restarted)


class LinkLearners:
    """Each link end is a learner, from the beacons of that link only."""

    statistics = 0

    def __init__(self, config: LinkSeekingConfig, draws: Draws, robots: int) -> None:
        self._config, self._draws, self._nothing = config, draws, np.zeros((robots, 0))

    def start(self) -> ReceptionFit:
        """No learner before the first link."""
        return packet_counting.no_counts(packet_counting.ALONE, 0)

    def of_links(self, links: Edges) -> Ints:
        """Each link end itself [l]."""
        return np.arange(len(links))

    def of_contacts(self, contact: Ints, around: Neighborhood) -> Ints:
        """The link of each contact [s]."""
        return np.searchsorted(around.link_contact, contact)

    def ahead(self, links: Edges) -> Floats:
        """A time of its own for each link [l] [s]."""
        return link_estimates.stagger(self._config, self._draws, links)

    def exchange(self, fit: ReceptionFit, around: Neighborhood) -> ReceptionFit:
        """Unchanged: robots share no counts."""
        return fit

    def shared(self, fit: ReceptionFit) -> Floats:
        """No statistics [n, 0]."""
        return self._nothing

    def carry(self, fit: ReceptionFit, old: Edges, new: Edges) -> ReceptionFit:
        """The learners of the links that remain, and new ones with the prior."""
        return packet_counting.carry(fit, old, new)

    def forget(self, fit: ReceptionFit, restarted: Bools, old: Edges, new: Edges) -> ReceptionFit:
        """The learners of the links that remain."""
        return packet_counting.carry(fit, old, new)
