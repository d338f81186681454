"""The reception model of a channel: the one of the class in force, with the memory of one file."""

import hashlib
import sys
import tracemalloc
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from fes.arrays.types import Floats
from fes.extension import NoParameters, registry
from fes.extension.context import SeededDraws, WorldContext
from fes.model.config import ObjectiveConfig
from world.config.radio import RadioConfig
from world.simulation import reception

ROWS = 20_000


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


def trace(file: Path) -> RadioConfig:
    """The channel of a trace of its own."""
    lines = "".join(f"{row * 1e-4:.4f},{row % 2},{1 - row % 2},1\n" for row in range(ROWS))
    file.write_text(f"time,sender,receiver,probability\n{lines}9,0,1,0.{file.stem}\n")
    settings: dict[str, Any] = {"trace": str(file), "trace_sha256": hashlib.sha256(file.read_bytes()).hexdigest()}
    return RadioConfig.model_validate({"model": "trace", **settings})


def test_the_rows_of_a_trace_are_in_memory_once_for_all_seeds_and_for_few_files(tmp_path: Path) -> None:
    number = ROWS * 8  # bytes of a column; a model has at least three
    same = trace(tmp_path / "1.csv")
    reception.model(same, context())
    tracemalloc.start()
    try:
        for seed in range(2, 8):
            reception.model(same, context(seed))
        assert tracemalloc.get_traced_memory()[0] < number
        for name in range(2, 32):
            reception.model(trace(tmp_path / f"{name}.csv"), context())
        assert tracemalloc.get_traced_memory()[0] < 15 * 3 * number
    finally:
        tracemalloc.stop()
