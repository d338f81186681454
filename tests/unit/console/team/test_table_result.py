"""The result of a team on a table, from reports and truth at times of their own."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.team import table_result
from console.team.table_result import TableResult, Truth
from fes.errors import FesError
from fes.protocol.report import Report
from tests.support import robot_teams

OPTIMUM, PERIOD = 68.0, 20.0


def report(*estimates: tuple[float, float]) -> Report:
    """A report with links 0-1, 1-2, ... and the estimates of both of their ends."""
    return robot_teams.merged(estimates)


def line_of_bodies(separation: float, until: float) -> Truth:
    """Three robots in a line, at this separation all the time."""
    positions = np.array([[0.0, 0.0], [separation, 0.0], [2 * separation, 0.0]])
    return Truth([0.0, until], np.array([positions, positions]), [0.0, until])


def run(estimates: list[float], truth: Truth) -> dict[str, Any]:
    """The summary of a run with one report per second, both links with the same estimate."""
    result = TableResult(OPTIMUM, PERIOD)
    for time, estimate in enumerate(estimates):
        result.add(report((estimate, estimate), (estimate, estimate)), float(time))
    return result.summary(0.0, truth)


def test_an_estimate_is_reached_from_the_time_on_from_which_it_stays_close() -> None:
    summary = run([80.0, 68.5, 70.0, 68.9, 67.1], line_of_bodies(68.0, 10.0))
    assert summary["estimate_time"] == 3.0
    assert summary["mean_estimate_error"] == pytest.approx(-0.9)


def test_an_estimate_that_leaves_at_the_end_is_not_reached() -> None:
    assert run([68.0, 68.0, 69.5], line_of_bodies(68.0, 10.0))["estimate_time"] is None


def test_separations_are_known_after_a_period_of_the_dither() -> None:
    assert run([68.0] * 15, line_of_bodies(68.0, 30.0))["separation_time"] is None
    summary = run([68.0] * 30, line_of_bodies(68.5, 30.0))
    assert summary["separation_time"] == pytest.approx(PERIOD)
    assert summary["separation_error_rms"] == pytest.approx(0.5)
    assert summary["links"] == 2


def test_an_oscillation_of_the_period_is_averaged() -> None:
    times = np.arange(0.0, 60.0, 0.1)
    separations = OPTIMUM + 5.0 * np.sin(2.0 * math.pi * times / PERIOD)
    positions = np.array([[[0.0, 0.0], [r, 0.0], [2.0 * r, 0.0]] for r in separations])
    summary = run([68.0] * 60, Truth(times.tolist(), positions, times.tolist()))
    assert summary["separation_time"] == pytest.approx(PERIOD)
    assert summary["separation_error_max"] < 0.3


def test_reports_at_irregular_times_leave_no_gap() -> None:
    result, time = TableResult(OPTIMUM, PERIOD), 0.0
    for number in range(400):
        time += 0.1 + 0.03 * (number % 3 - 1)
        result.add(report((68.0, 68.0)), time)
    assert result.summary(0.0, line_of_bodies(68.4, 60.0))["separation_time"] == pytest.approx(PERIOD, abs=0.3)


def test_reports_before_the_start_do_not_count() -> None:
    result = TableResult(OPTIMUM, None)
    result.add(report((68.0, 68.0)), 1.0)
    summary = result.summary(2.0, line_of_bodies(68.0, 10.0))
    assert summary["links"] == 0
    assert summary["mean_estimate_error"] is None


def test_time_for_which_the_bodies_stood_still_is_told() -> None:
    truth = Truth([0.0, 1.0, 2.0, 3.0], np.zeros((4, 2, 2)), [0.0, 0.9, 1.4, 2.4])
    assert truth.lost(0.0) == pytest.approx(0.6)
    assert truth.lost(1.5) == pytest.approx(0.0)


def test_a_cut_file_of_the_truth_ends_at_its_last_whole_line(tmp_path: Path) -> None:
    path = tmp_path / "truth.jsonl"
    lines = [json.dumps({"monotonic": time, "time": time, "poses": [[time, 0.0, 0.0]]}) for time in (1.0, 2.0, 3.0)]
    path.write_text("\n".join(lines)[:-5])
    truth = table_result.read_truth(path)
    assert truth.times == [1.0, 2.0]
    assert truth.positions_at(1.25).tolist() == [[1.25, 0.0]]


def test_a_file_without_truth_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "truth.jsonl"
    path.write_text("")
    with pytest.raises(FesError, match="has fewer than two lines of true poses"):
        table_result.read_truth(path)
    with pytest.raises(FesError, match="cannot be read"):
        table_result.read_truth(tmp_path / "absent")
