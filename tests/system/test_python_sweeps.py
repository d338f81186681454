"""fes.sweep: its table, its errors, and its workers."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

import fes
from console.api.sweep_table import SweepTable
from fes.errors import FesError
from tests.support.loop import load

AXES: dict[str, Iterable[object]] = {"formation.rule": ["disk", "two_nearest"], "run.dt": np.array([0.02, 0.01])}
SHORT = {"run": {"duration": 0.4}}


@pytest.fixture(scope="module")
def table() -> SweepTable:
    return fes.sweep("pair", AXES, seeds=range(3), overrides=SHORT, jobs=2)


def test_a_table_has_the_row_of_each_run(table: SweepTable) -> None:
    assert len(table) == 2 * 2 * 3
    assert table.axes == {"formation.rule": ["disk", "two_nearest"], "run.dt": [0.02, 0.01]}
    row = table.rows[4]
    assert (row["formation.rule"], row["run.dt"], row["seed"], row["error"]) == ("disk", 0.01, 1, None)
    run = fes.run("pair", 1, overrides={**SHORT, "run.dt": 0.01, "formation.rule": "disk"})
    assert row["digest"] == run.digest
    assert row["separation_error_max"] == run.summary["separation_error_max"]


def test_columns_are_arrays_and_a_grid_has_a_dimension_per_axis(table: SweepTable) -> None:
    assert table["seed"].tolist() == [0, 1, 2] * 4
    assert table["seed"].dtype == np.int64
    assert table["time_to.estimate_1m"].dtype == np.float64
    grid = table.grid("digest")
    assert grid.shape == (2, 2, 3)
    assert grid[0, 1, 1] == table.rows[4]["digest"]
    assert set(table.numpy()) == set(table.columns)
    with pytest.raises(FesError, match=r"no column 'estimate_1m': the nearest is 'time_to\.estimate_1m'"):
        table["estimate_1m"]


def test_cells_and_differences_are_those_of_the_rows(table: SweepTable) -> None:
    largest = table.grid("separation_error_max")
    cells = [row for row in table.cells.rows if row["outcome"] == "separation_error_max"]
    assert [row["mean"] for row in cells] == pytest.approx(largest.mean(axis=2).ravel().tolist(), rel=1e-15)
    paired = [row for row in table.differences.rows if row["outcome"] == "separation_error_max"]
    between_rules = [row["mean"] for row in paired if row["axis"] == "formation.rule"]
    assert between_rules == pytest.approx((largest[1] - largest[0]).mean(axis=1).tolist(), rel=1e-12, abs=1e-15)


def test_the_frames_of_a_sweep_have_its_columns(table: SweepTable) -> None:
    frame = table.frame()
    assert list(frame.columns) == table.columns
    assert frame.groupby("formation.rule")["seed"].count().to_dict() == {"disk": 6, "two_nearest": 6}


def test_a_finished_sweep_is_not_run_again(tmp_path: Path) -> None:
    seen: list[int] = []
    first = fes.sweep("pair", seeds=[5], overrides=SHORT, out=tmp_path / "out", jobs=1)

    def show(done: int, total: int) -> None:
        seen.append(done)

    again = fes.sweep("pair", seeds=[5, 6], overrides=SHORT, out=tmp_path / "out", jobs=1, progress=show)
    assert again.rows[0] == first.rows[0]
    assert min(seen) == 20 == max(seen) - 20


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"axes": {"run.seed": [1]}}, "seeds: sets the seeds: 'run.seed' can be neither an axis nor in overrides"),
        ({"overrides": {"run.seed": 1}}, "seeds: sets the seeds"),
        ({"axes": {"run.dt": [0.01]}, "overrides": {"run.dt": 0.01}}, "axes: 'run.dt' is given by overrides, and"),
        ({"axes": {"run.dt": [0.01, 0.01]}}, "axes: expects each value of 'run.dt' once"),
        ({"axes": {"run.dt": 0.01}}, "axes: 'run.dt' expects a list of values, got 0.01"),
        ({"axes": {"formation.rule": "disk"}}, "axes: 'formation.rule' expects a list of values, got 'disk'"),
        ({"axes": {"run.dt": []}}, "axes: 'run.dt' expects a list of values"),
        ({"axes": {"run.clock": ["live"]}}, "run.clock: 'live' needs processes"),
        ({"axes": {"run": [{"dt": 0.01}]}}, "axes: expects a field, and 'run' is a table"),
        ({"seeds": [0.5]}, r"seeds: expects whole numbers, such as range\(20\), got \[0.5\]"),
        ({"seeds": 3}, r"seeds: expects whole numbers, such as range\(20\), got 3"),
        ({"seeds": []}, "seeds: expects"),
        ({"seeds": [1, 1]}, "seeds: expects each seed once"),
        ({"seeds": range(10**9)}, "seeds: lists at most 1000000 seeds"),
        ({"jobs": 0}, "jobs: expects at least 1 worker process"),
        ({"jobs": 1, "scheduler": "tcp://127.0.0.1:8786"}, "jobs: expects at least 1 worker process, without a"),
        ({"scheduler": "here"}, "scheduler expects an address such as"),
    ],
)
def test_an_invalid_argument_is_an_error_of_one_line_in_the_words_of_python(
    arguments: dict[str, object], message: str
) -> None:
    with pytest.raises(FesError, match=message) as refused:
        fes.sweep("pair", **{"seeds": [0], **arguments})  # type: ignore[arg-type]
    assert "\n" not in str(refused.value)
    assert "--" not in str(refused.value)


def test_a_scenario_object_is_swept_as_its_file_is(table: SweepTable) -> None:
    own = fes.sweep(load("pair.toml", run__duration=0.4), AXES, seeds=range(3), jobs=1)
    assert own.rows == table.rows
