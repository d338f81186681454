"""The built-in channels that have a formula: equations (3) and (4), and two that are not Rayleigh."""

from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from fes.model import outage
from fes.model.config import ChannelConfig


class Formula:
    """The channels `rayleigh`, `logistic` and `perfect`."""

    Parameters = ChannelConfig

    def __init__(self, parameters: ChannelConfig, context: WorldContext) -> None:
        self._channel = parameters

    @property
    def scale(self) -> float:
        """c [m^-nu] of the reception probability exp(-c r^nu); 0 for a channel that is not of this form."""
        return 0.0 if self._channel.model == "logistic" else outage.exponent_scale(self._channel)

    def probability(self, separation: Floats) -> Floats:
        """Probability that a beacon decodes at `separation` [m], of the same shape."""
        return outage.reception_probability(separation, self._channel)
