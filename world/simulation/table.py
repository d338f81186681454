"""The channel `table`: measured reception probabilities, interpolated."""

import numpy as np

from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from world.config.radio import RadioConfig


class TableChannel:
    """Straight lines between the rows, constant beyond them."""

    Parameters = RadioConfig

    def __init__(self, parameters: RadioConfig, context: WorldContext) -> None:
        self._separation, self._probability = np.array(parameters.rows, dtype=np.float64).T

    def probability(self, separation: Floats) -> Floats:
        """Probability that a beacon decodes at `separation` [m], of the same shape."""
        probability: Floats = np.interp(separation, self._separation, self._probability)
        return probability
