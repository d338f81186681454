"""The channel `table`: straight lines between rows, constant beyond, and it need not fall."""

from typing import Any

import numpy as np
import pytest

from fes.errors import ScenarioError
from fes.extension.context import SeededDraws, WorldContext
from fes.model.config import ObjectiveConfig
from tests.support.radios import ledger, stand, started
from world.config import events
from world.config.radio import RadioConfig
from world.config.scenario import Scenario, parse
from world.simulation import reception

CONTEXT = WorldContext(0.02, 2, ObjectiveConfig(), SeededDraws(1))
ROWS = [[20.0, 1.0], [60.0, 0.5], [80.0, 0.75], [100.0, 0.0]]


def values(rows: list[list[float]], *separations: float) -> list[float]:
    model = reception.model(RadioConfig(model="table", rows=rows), CONTEXT)  # type: ignore[arg-type]
    result: list[float] = model.probability(np.array(separations)).tolist()
    return result


def pair(separation: float, **channel: Any) -> Scenario:
    poses = [[0.0, 0.0, 0.0], [separation, 0.0, 0.0]]
    tables = {"schema": 1, "robots": {"poses": poses}, "seeking": {"index": "measured"}}
    return parse({**tables, "channel": {"model": "table", "rows": ROWS, **channel}}, "here")


def test_a_value_lies_on_the_line_between_two_rows_and_is_constant_beyond_them() -> None:
    assert values(ROWS, 0.0, 20.0, 40.0, 60.0, 70.0, 80.0, 90.0, 100.0, 149.0) == [
        1.0, 1.0, 0.75, 0.5, 0.625, 0.75, 0.375, 0.0, 0.0,
    ]  # fmt: skip


def test_the_shape_is_that_of_the_separations() -> None:
    model = reception.model(RadioConfig(model="table", rows=ROWS), CONTEXT)  # type: ignore[arg-type]
    assert model.probability(np.zeros(0)).shape == (0,)
    assert model.probability(np.full((2, 3), 40.0)).tolist() == [[0.75] * 3] * 2


def test_beacons_decode_as_often_as_the_table_says() -> None:
    ticks = 6000
    world, state = started(pair(70.0))
    decoded = ledger(stand(world, state, ticks), "decoded")
    sigma = np.sqrt(0.625 * 0.375 / (ticks - 1))
    assert decoded[0, 1] / (ticks - 1) == pytest.approx(0.625, abs=4 * sigma)  # binomial


def test_shadowing_moves_the_separation_at_which_a_table_is_read() -> None:
    world, state = started(pair(40.0, shadowing={"deviation": 6.0}, path_loss_exponent=2.0))
    state = stand(world, state, 3)
    shadowed = ledger(state, "probability")[0, 1]
    world, state = started(pair(40.0, shadowing={"deviation": 0.0}))
    assert ledger(stand(world, state, 3), "probability")[0, 1] == 0.75
    assert abs(shadowed - 0.75) > 0.01


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "channel: rows: model 'table' needs at least two, got 0"),
        ([[10.0, 1.0]], "channel: rows: model 'table' needs at least two, got 1"),
        ([[10.0, 1.0], [10.0, 0.5]], "channel: rows: separations must ascend, got 10 and then 10"),
        ([[30.0, 1.0], [20.0, 0.5]], "channel: rows: separations must ascend, got 30 and then 20"),
        ([[10.0, 1.5], [20.0, 0.5]], "channel.rows.0.1: must be less than or equal to 1, got 1.5"),
        ([[-10.0, 1.0], [20.0, 0.5]], "channel.rows.0.0: must be greater than or equal to 0, got -10.0"),
        ([[10.0, float("nan")], [20.0, 0.5]], "channel.rows.0.1: must be less than or equal to 1, got nan"),
        ([[10.0], [20.0, 0.5]], "channel.rows.0.1: is required"),
    ],
)
def test_a_broken_table_is_refused_in_one_line(rows: list[list[float]], message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        pair(50.0, rows=rows)
    assert str(caught.value) == f"here: {message}"


def test_the_rows_of_a_table_can_change_during_a_run() -> None:
    before = pair(50.0).channel
    after = events.changed(before, {"channel.rows": [[0.0, 0.25], [90.0, 0.5]]}, 0.02)
    assert reception.model(after, CONTEXT).probability(np.array([45.0])).tolist() == [0.375]
    assert reception.model(before, CONTEXT).probability(np.array([40.0])).tolist() == [0.75]
