"""The history of a run for a page: bins, paths, and a world that resumes at an earlier tick."""

import math
from dataclasses import replace

import numpy as np
import pytest

from console.web.history import BINS, MOST_CHANGES, PATH_LENGTH, PATH_POINTS, History
from fes.protocol.report import Report
from tests.support.frames import a_report


def at(tick: int, **fields: object) -> Report:
    """A report of two robots at a tick; the first one drives along x, one meter per tick."""
    return replace(a_report([(float(tick), 0.0), (0.0, 60.0)], [(0, 1)]), tick=tick, **fields)  # type: ignore[arg-type]


def filled(ticks: range, **fields: object) -> History:
    history = History()
    for tick in ticks:
        history.add(at(tick, **fields))
    return history


def test_a_short_run_has_every_report() -> None:
    history = History()
    for tick in range(0, 100, 5):
        history.add(at(tick, disagreement=1.0 + tick, estimate_error_max=2.0, separation_error_max=math.nan))
    curves = history.curves()
    assert curves["time"] == pytest.approx(0.02 * np.arange(0, 100, 5))
    assert curves["first"].tolist() == [1.0 + tick for tick in range(0, 100, 5)]
    assert curves["second"].tolist() == [2.0] * 20
    assert np.isnan(curves["third"]).all()
    assert np.isnan(curves["index"]).all()


def test_a_log_axis_gets_no_zero() -> None:
    history = filled(range(3), disagreement=0.0)
    assert np.isnan(history.curves()["first"]).all()


def test_a_long_run_keeps_its_worst_values() -> None:
    history = History()
    last = 10 * BINS
    for tick in range(last + 1):
        history.add(at(tick, disagreement=1000.0 if tick == 3333 else 1.0))
    curves = history.curves()
    assert BINS // 2 < len(curves["time"]) <= BINS
    assert curves["time"][-1] == pytest.approx(0.02 * last)
    assert np.all(np.diff(curves["time"]) > 0.0)
    [spike] = np.flatnonzero(curves["first"] == 1000.0)
    assert curves["time"][spike] == pytest.approx(0.02 * 3333, abs=0.02 * 16)


def test_a_world_that_resumes_replaces_the_ticks_after_it() -> None:
    history = filled(range(100))
    for tick in range(40, 60):
        history.add(at(tick, disagreement=7.0))
    curves = history.curves()
    assert curves["time"] == pytest.approx(0.02 * np.arange(60))
    assert curves["first"].tolist() == [2.5] * 40 + [7.0] * 20
    assert len(history.paths(59)["x"]) == 2 * (60 + 1)


def test_another_run_begins_a_new_history() -> None:
    history = filled(range(100))
    history.add(at(500, scenario="other"))
    assert history.curves()["time"].tolist() == [10.0]
    history.add(replace(a_report([(0.0, 0.0)]), scenario="other", tick=600))
    assert len(history.paths(600)["x"]) == 2


def test_paths_end_at_the_tick_that_is_shown_and_have_gaps_between_robots() -> None:
    paths = filled(range(20)).paths(9)
    assert paths["x"][:10].tolist() == list(range(10))
    assert math.isnan(paths["x"][10])
    assert paths["y"][11:21].tolist() == [60.0] * 10
    assert math.isnan(paths["y"][21])
    assert len(paths["x"]) == 22


def test_a_trail_has_no_absurd_place_which_would_shrink_the_map() -> None:
    history = filled(range(3))
    history.add(replace(a_report([(1e12, 0.0), (0.0, 60.0)]), tick=3))
    paths = history.paths(3)
    assert np.nanmax(np.abs(paths["x"])) == 2.0
    assert np.isnan(paths["y"][[3, 4]]).all()
    assert paths["y"][5:9].tolist() == [60.0] * 4


@pytest.mark.parametrize("robots", [2, 500])
def test_paths_of_a_long_run_have_a_bounded_number_of_points_over_all_of_it(robots: int) -> None:
    history = History()
    for tick in range(5000):
        history.add(replace(a_report([(float(tick), 0.0)] * robots), tick=tick))
    path = history.paths(5000)["x"]
    each = len(path) // robots
    assert robots * (each - 1) <= max(PATH_LENGTH * robots if robots == 2 else 0, PATH_POINTS)
    assert path[0] == 0.0
    assert path[each - 2] > 4000.0


def test_changes_of_the_channel_are_marked_once_each() -> None:
    history = filled(range(50))
    for tick in range(50, 60):
        history.add(at(tick, changed_at=1.0))
    assert history.changes()["time"].tolist() == [1.0]
    for tick in range(60, 60 + 2 * MOST_CHANGES):
        history.add(at(tick, changed_at=0.02 * tick))
    assert len(history.changes()["time"]) == MOST_CHANGES
