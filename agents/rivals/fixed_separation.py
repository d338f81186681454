"""A fixed separation: every link is driven to the same constant length. Nothing is sought.

It represents formation control with a length that was chosen before the mission.
"""

import numpy as np

from fes.extension import (
    Bools,
    Edges,
    Entry,
    Floats,
    Formed,
    LawContext,
    Neighborhood,
    Positive,
    Published,
    Table,
    elementary,
)

DISTINCT = 0.95
"""Factor [1 - exp(-(r/r_min)^s)] of (16) at the default separation: 5 % less than the most that a link can have."""


class FixedSeparationParameters(Table):
    """The parameters of `fixed_separation`."""

    separation: Positive | None = None
    """Separation of every link [m]. By default, that at which the factor of (16) that grows with it is 0.95: 1.316
    r_min with a shape exponent of 4. That depends on the objective alone, and not on the channel."""


class FixedSeparation:
    """The seeking law that does not seek. It has no state."""

    Parameters = FixedSeparationParameters
    knows_channel = False
    statistics = 0
    declared = 0
    learnt: tuple[str, ...] = ()

    def __init__(self, parameters: FixedSeparationParameters, context: LawContext) -> None:
        objective = context.objective
        spread = -elementary.log(np.array([1.0 - DISTINCT]))
        least = objective.minimum_separation * elementary.power(spread, 1.0 / objective.shape_exponent)
        self.separation = float(least[0]) if parameters.separation is None else parameters.separation
        self._nothing = np.zeros((len(context.ids), 0))

    def start(self) -> None:
        """No state."""

    def forget(self, state: None, restarted: Bools, old: Edges, new: Edges) -> None:
        """No state."""

    def relink(self, state: None, old: Edges, new: Edges, entry: Entry) -> None:
        """No state."""

    def desired(self, state: None, tick: int, links: Edges) -> Floats:
        """The separation, for each link [l] [m]."""
        return np.full(len(links), self.separation)

    def measure(self, state: None, around: Neighborhood, formed: Formed) -> None:
        """Unchanged: no beacon is counted."""

    def publish(self, state: None, links: Edges) -> Published:
        """The separation as the estimate of each link."""
        return Published(np.full(len(links), self.separation), self._nothing, np.zeros((0, len(links))))

    def seek(self, state: None, around: Neighborhood) -> None:
        """Unchanged: the separation stays as it is."""
