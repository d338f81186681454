"""The channel, for a law that is told it. This module knows the formula; only a process with such a law loads it."""

from fes.arrays.types import Floats
from fes.model import outage
from fes.model.config import ChannelConfig


class ToldChannel:
    """The true channel's formula."""

    def __init__(self, config: ChannelConfig) -> None:
        self.config = config
        """Its settings."""

    def probability(self, separation: Floats) -> Floats:
        """Probability that a beacon decodes at `separation` [m], of the same shape."""
        return outage.reception_probability(separation, self.config)

    def log_slope(self, separation: Floats) -> Floats:
        """(ln p)' of that probability at `separation` [m], of the same shape [1/m]."""
        return outage.log_reception_slope(separation, self.config)
