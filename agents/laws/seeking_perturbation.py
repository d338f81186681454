"""The seeking laws that climb an index by perturbation (18): with the oracle's index, and with samples of J."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from agents.laws import link_estimates, perturbation
from agents.laws.perturbation import ESTIMATE, Index, Seeker
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats
from fes.extension.context import LawContext
from fes.extension.neighborhood import Entry, Neighborhood
from fes.extension.protocols import Formed, Published
from fes.model import objective
from fes.model.seeking import PerturbationConfig, SampledConfig


class PerturbationSeeking:
    """(18) with any index; its state is [3, l], rows as in `agents.laws.perturbation`."""

    knows_channel = False
    statistics = 0
    declared = 0
    learnt: tuple[str, ...] = ()

    def __init__(self, parameters: PerturbationConfig, context: LawContext, index: Index) -> None:
        self.seeker = Seeker(parameters, index, context.dt)
        self.context = context
        self._nothing = np.zeros((len(context.ids), 0))

    def start(self) -> Floats:
        """No link."""
        return np.zeros((3, 0))

    def forget(self, state: Floats, restarted: Bools, old: Edges, new: Edges) -> Floats:
        """The state of the links that remain."""
        return new.carry(state, old, np.nan, axis=1)

    def relink(self, state: Floats, old: Edges, new: Edges, entry: Entry) -> Floats:
        """The state over the links `new`."""
        return perturbation.relink(self.seeker, self.context.draws, old, state, new, entry)

    def desired(self, state: Floats, tick: int, links: Edges) -> Floats:
        """The estimates."""
        estimates: Floats = state[ESTIMATE]
        return estimates

    def measure(self, state: Floats, around: Neighborhood, formed: Formed) -> Floats:
        """Unchanged: nothing is counted."""
        return state

    def publish(self, state: Floats, links: Edges) -> Published:
        """The estimates alone."""
        return Published(state[ESTIMATE], self._nothing, np.zeros((0, len(links))))

    def seek(self, state: Floats, around: Neighborhood) -> Floats:
        """One tick of (18)."""
        return self.climb(state, around, None)

    def climb(self, state: Floats, around: Neighborhood, index: Index | None) -> Floats:
        """One tick of (18) with this index, by default that of the law."""
        peers = perturbation.extrapolate(self.seeker, state, around.peer_estimates, around.age)
        skew = self.context.skew(around.tick, around.links)
        return perturbation.advance(self.seeker, around.tick, state, peers, skew, index)


class SampledSeeking(PerturbationSeeking):
    """(18) with samples of J. The dither is physical: the robots drive to the dithered separations."""

    Parameters = SampledConfig

    def __init__(self, parameters: SampledConfig, context: LawContext) -> None:
        # The first baseline of a link is S(r).
        super().__init__(parameters, context, _Flat(partial(objective.preference, objective=context.objective)))

    def desired(self, state: Floats, tick: int, links: Edges) -> Floats:
        """The estimates, with the dither of each robot's clock."""
        time = tick * self.context.dt + self.context.skew(tick, links)
        desired: Floats = state[ESTIMATE] + link_estimates.dither(self.seeker.config, time)
        return desired

    def estimates(self, state: Floats, links: Edges) -> Floats:
        """The estimates alone."""
        estimates: Floats = state[ESTIMATE]
        return estimates

    def seek(self, state: Floats, around: Neighborhood) -> Floats:
        """One tick of (18) with this tick's samples: each counts at every separation."""
        drawn = sample(around, self.context)
        return self.climb(state, around, _Flat(lambda separation: np.broadcast_to(drawn, separation.shape).copy()))


@dataclass(frozen=True, eq=False)
class _Flat:
    """An index whose slope is not known."""

    value: Callable[[Floats], Floats]

    def __call__(self, separation: Floats) -> Floats:
        return self.value(separation)

    def parabola(self, separation: Floats) -> tuple[Floats, Floats, Floats]:
        flat = np.zeros_like(separation)
        return self.value(separation), flat, flat

    def trusted(self, separation: Floats) -> Floats:
        return np.full_like(separation, np.inf)


def sample(around: Neighborhood, context: LawContext) -> Floats:
    """One sample of J of (16) for each link [l]: S(r) if the last tick's beacon decoded, else 0.

    Its mean is S(r) p(r) at the true separation r. A real radio cannot give (18) a better sample.
    """
    separation = around.contacts.separation.take(around.link_contact)
    is_heard = around.is_heard.take(around.link_contact)
    return np.where(is_heard, objective.preference(separation, context.objective), 0.0)
