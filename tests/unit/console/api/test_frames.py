"""Data frames of pandas, and the one line without it."""

import sys

import numpy as np
import pytest

import fes
from console.api import columns
from fes.errors import FesError


def test_the_frame_of_a_run_has_a_row_per_tick_and_robot() -> None:
    run = fes.run("paper", duration=0.2)
    frame = run.frame()
    assert list(frame.columns) == ["tick", "time", "robot", "x", "y", "heading", "linear", "angular"]
    assert len(frame) == 10 * 10
    row = frame[(frame.tick == 7) & (frame.robot == 3)].iloc[0]
    assert row[["x", "y", "heading"]].tolist() == run.poses[7, 3].tolist()
    assert row[["linear", "angular"]].tolist() == run.twists[7, 3].tolist()
    assert row.time == run.time[7]


def test_the_frame_of_the_links_has_their_columns() -> None:
    links = fes.run("pair", duration=0.4).links
    frame = links.frame()
    assert {name: frame[name].to_numpy().tolist() for name in frame} == {
        name: column.tolist() for name, column in vars(links).items()
    }


def test_a_frame_without_pandas_is_an_error_that_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)  # as Python marks a module that cannot be imported
    run = fes.run("pair", duration=0.1)
    with pytest.raises(
        FesError, match=r"^frame\(\) needs pandas: pip install -e '\.\[notebook\]'  # in a clone of fes$"
    ):
        run.frame()


def test_a_column_has_the_narrowest_type_of_its_values() -> None:
    kinds = [columns.column(values).dtype for values in ([True], [1, 2], [1, 2.5], [None], ["a"], [True, 2])]
    assert kinds == [np.bool_, np.int64, np.float64, np.float64, object, np.float64]
    assert columns.column([None], is_text=True).tolist() == [None]
    assert np.isnan(columns.column([1, None]))[1]
