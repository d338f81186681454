"""The seeking laws that climb ln J along the slope measured by counting beacons: pooled, or each link alone.

The dither is physical: the robots drive to the dithered separations.
"""

from dataclasses import dataclass, replace

import numpy as np

from agents.laws import link_estimates, packet_counting
from agents.laws.learners import Learners, LinkLearners, RobotLearners
from agents.laws.packet_counting import ReceptionFit
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats
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
    """One row per learner."""


class MeasuredSeeking:
    """The law, for any learners."""

    Parameters = MeasuredConfig
    knows_channel = False
    declared = 0
    learnt = ("level", "exponent")

    def __init__(self, parameters: MeasuredConfig, context: LawContext, learners: Learners) -> None:
        self.config, self.context, self._learners = parameters, context, learners
        self.statistics = learners.statistics
        """Number of statistics in each beacon."""

    def start(self) -> Measured:
        """No link, and no beacon counted."""
        nothing = np.zeros(0)
        return Measured(nothing, nothing, self._learners.start())

    def forget(self, state: Measured, restarted: Bools, old: Edges, new: Edges) -> Measured:
        """The state without the links that are gone, and without the counts of the robots `restarted` [n]."""
        estimates, ahead = new.carry(state.estimates, old, np.nan), new.carry(state.ahead, old, 0.0)
        return Measured(estimates, ahead, self._learners.forget(state.fit, restarted, old, new))

    def relink(self, state: Measured, old: Edges, new: Edges, entry: Entry) -> Measured:
        """The state over the links `new`."""
        config, draws, transition = self.config, self.context.draws, new.after(old)
        estimates, ahead = transition.carry(state.estimates, np.nan), transition.carry(state.ahead, 0.0)
        is_new = transition.is_new
        if is_new.any():
            begun = new.select(is_new)
            estimates[is_new] = link_estimates.of_new_links(config, draws, old, state.estimates, begun, entry)
            ahead[is_new] = self._learners.ahead(begun)
        return Measured(estimates, ahead, self._learners.carry(state.fit, old, new))

    def desired(self, state: Measured, tick: int, links: Edges) -> Floats:
        """The estimates, with the dither of each robot's clock."""
        time = tick * self.context.dt + self.context.skew(tick, links)
        desired: Floats = state.estimates + link_estimates.dither(self.config, time + state.ahead)
        return desired

    def estimates(self, state: Measured, links: Edges) -> Floats:
        """The estimates alone."""
        return state.estimates

    def measure(self, state: Measured, around: Neighborhood, formed: Formed) -> Measured:
        """The fit of the channel after the beacons of the previous tick."""
        slots = around.slots
        fit = packet_counting.fade(self._learners.exchange(state.fit, around), self.context.dt)
        rows, scale = self._learners.of_contacts(slots.contact, around), self.config.reference_separation
        return replace(state, fit=packet_counting.learn(fit, rows, slots.separation, slots.decoded, scale))

    def publish(self, state: Measured, links: Edges) -> Published:
        """The estimates, the statistics that robots share, and the fit of each link."""
        rows = self._learners.of_links(links)
        learnt = np.stack([state.fit.level.take(rows), state.fit.exponent.take(rows)])
        return Published(state.estimates, self._learners.shared(state.fit), learnt)

    def seek(self, state: Measured, around: Neighborhood) -> Measured:
        """The estimates after a tick of climbing the fit's slope of ln J, and of consensus with the peers."""
        estimates, scale = state.estimates, self.config.reference_separation
        objective, rows = self.context.objective, self._learners.of_links(around.links)
        speed = packet_counting.drift(state.fit, rows, estimates, objective, scale, around.link_quality_weight)
        peers = around.peer_estimates
        speed += self.config.consensus_gain * np.where(np.isfinite(peers), peers - estimates, 0.0)
        return replace(state, estimates=packet_counting.bounded(estimates + self.context.dt * speed, objective))


class PooledSeeking(MeasuredSeeking):
    """Each robot learns from all its links, and from the robots that it hears."""

    def __init__(self, parameters: MeasuredConfig, context: LawContext) -> None:
        super().__init__(parameters, context, RobotLearners(len(context.ids)))


class LinkSeeking(MeasuredSeeking):
    """Each link end learns from the beacons of that link only: better under shadowing."""

    def __init__(self, parameters: MeasuredConfig, context: LawContext) -> None:
        super().__init__(parameters, context, LinkLearners(parameters, context.draws, len(context.ids)))
