"""Cells and paired differences, against scipy and hand algebra."""

import math

import numpy as np
import pytest
from scipy import stats

from console.sweep import comparison, design, picture
from console.sweep.design import Design
from console.sweep.table import Row
from fes.arrays.types import Floats
from tests.support.paths import CONFIGS


@pytest.fixture
def planned() -> Design:
    return design.plan(CONFIGS / "pair.toml", ["formation.rule=disk,two_nearest"], "0:4", [])


def table(disk: list[float | None], nearest: list[float | None]) -> list[Row]:
    rows: list[Row] = []
    for rule, times in (("disk", disk), ("two_nearest", nearest)):
        rows += [
            {"formation.rule": rule, "seed": seed, "robots": 2, "time": time, "digest": "f00", "error": None}
            for seed, time in enumerate(times)
        ]
    return rows


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 5, 9, 10, 30, 99, 1000])
@pytest.mark.parametrize("confidence", [0.5, 0.95, 0.999])
def test_student_t_is_that_of_scipy(freedom: int, confidence: float) -> None:
    expected = stats.t.ppf(0.5 + 0.5 * confidence, freedom)
    assert comparison.student_t(freedom, confidence) == pytest.approx(expected, rel=1e-11)


def test_an_interval_is_that_of_scipy() -> None:
    sample = np.random.default_rng(4).gamma(2.0, 3.0, 17)
    mean, low, high = comparison.interval(sample)
    expected = stats.t.interval(0.95, 16, sample.mean(), stats.sem(sample))
    assert (mean, low, high) == pytest.approx((sample.mean(), *expected), rel=1e-11)


def test_one_pair_has_no_interval_and_zero_pairs_have_no_mean() -> None:
    mean, low, high = comparison.interval(np.array([2.5]))
    assert mean == 2.5
    assert math.isnan(low)
    assert math.isnan(high)
    assert all(math.isnan(value) for value in comparison.interval(np.zeros(0)))


def test_a_difference_pairs_runs_of_one_seed_so_that_the_effect_of_the_seed_cancels(planned: Design) -> None:
    # Each seed shifts both cells by its own amount: by hand, the difference is 2 at every seed, with no spread.
    (difference,) = comparison.differences(planned, table([1.0, 10.0, 100.0, 1000.0], [3.0, 12.0, 102.0, 1002.0]))
    assert (difference.base, difference.compared, difference.outcome, difference.pairs) == (0, 1, "time", 4)
    assert (difference.mean, difference.low, difference.high) == (2.0, 2.0, 2.0)


def test_a_run_that_never_reaches_a_level_is_counted_but_has_no_value(planned: Design) -> None:
    rows = table([1.0, None, 3.0, None], [None, 5.0, 4.0, None])
    disk, nearest = comparison.spreads(planned, rows)
    assert (disk.runs, disk.reached, disk.mean, disk.largest) == (4, 2, 2.0, 3.0)
    assert (nearest.reached, nearest.median) == (2, 4.5)
    (difference,) = comparison.differences(planned, rows)
    assert (difference.pairs, difference.only_base, difference.only_other, difference.mean) == (1, 1, 1, 1.0)


def test_a_cell_in_which_no_run_reaches_a_level_has_no_mean(planned: Design) -> None:
    disk, _ = comparison.spreads(planned, table([None] * 4, [None] * 4))
    assert disk.reached == 0
    assert math.isnan(disk.mean)


def test_an_outcome_is_looked_up_once_for_any_number_of_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    wide = design.plan(CONFIGS / "pair.toml", ["run.dt=0.02,0.01,0.005,0.004"], "0:1", [])
    rows: list[Row] = [{"seed": 0, "x": 1.0, "y": 2.0} for _ in range(4)]
    asked, values = [], comparison.values

    def counted(planned: Design, rows: list[Row], outcome: str) -> Floats:
        asked.append(outcome)
        return values(planned, rows, outcome)

    monkeypatch.setattr(comparison, "values", counted)
    assert len(list(comparison.differences(wide, rows))) == 6
    assert asked == ["x", "y"]


def test_the_figure_names_its_axes() -> None:
    crossed = design.plan(CONFIGS / "pair.toml", ["formation.rule=disk,two_nearest", "run.dt=0.02,0.01"], "0:1", [])
    rows: list[Row] = [{"seed": 0, "time_to.x": float(cell)} for cell in range(4)]
    drawn = picture.sweep_figure(crossed, rows, list(comparison.differences(crossed, rows)))
    [legend] = drawn.legends
    assert legend.get_title().get_text() == "formation.rule, run.dt"


def test_each_axis_is_compared_with_its_first_value_while_the_others_are_fixed() -> None:
    crossed = design.plan(
        CONFIGS / "pair.toml", ["formation.rule=disk,two_nearest", "run.dt=0.02,0.01,0.005"], "0:1", []
    )
    rows: list[Row] = [{"seed": 0, "x": float(cell**2)} for cell in range(6)]
    contrasts = [(each.axis, each.base, each.compared, each.mean) for each in comparison.differences(crossed, rows)]
    assert contrasts == [
        (0, 0, 3, 9.0),
        (0, 1, 4, 15.0),
        (0, 2, 5, 21.0),
        (1, 0, 1, 1.0),
        (1, 0, 2, 4.0),
        (1, 3, 4, 7.0),
        (1, 3, 5, 16.0),
    ]
    assert crossed.contrast(0, 1, 4) == ("two_nearest - disk", "0.01")
