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
        row = np.searchsorted(self._separation, separation, "right")
        left, right = np.maximum(row - 1, 0), np.minimum(row, len(self._separation) - 1)
        length = self._separation[right] - self._separation[left]
        is_between = length > 0.0
        share = np.where(is_between, separation - self._separation[left], 0.0) / np.where(is_between, length, 1.0)
        climb = self._probability[right] - self._probability[left]
        probability: Floats = self._probability[left] + share * climb
        return probability
