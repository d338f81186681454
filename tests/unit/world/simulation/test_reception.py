"""The reception model of a channel: the one of the class in force."""

import sys
from types import ModuleType

import numpy as np
import pytest

from fes.arrays.types import Floats
from fes.extension import NoParameters, registry
from fes.extension.context import SeededDraws, WorldContext
from fes.model.config import ObjectiveConfig
from world.config.radio import RadioConfig
from world.simulation import reception


def context(seed: int = 1) -> WorldContext:
    return WorldContext(0.02, 2, ObjectiveConfig(), SeededDraws(seed))


def constant(value: float) -> type:
    """A channel that decodes this share of the beacons."""

    class Channel:
        Parameters = NoParameters

        def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
            pass

        def probability(self, separation: Floats) -> Floats:
            return np.full(separation.shape, value)

    return Channel


def test_a_class_that_is_defined_again_under_its_name_is_the_one_that_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    cells = ModuleType("notebook_cells")
    monkeypatch.setitem(sys.modules, "notebook_cells", cells)
    registry.use("notebook_cells")
    config = RadioConfig.model_validate({"model": "notebook_cells:Channel"})
    for value in (0.25, 1.0):
        vars(cells)["Channel"] = constant(value)
        assert reception.model(config, context()).probability(np.array([40.0])).tolist() == [value]
    registry.withdraw("notebook_cells")
