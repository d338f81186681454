"""The lines after fes team run."""

from pathlib import Path
from typing import Any

import pytest

from console.team.table_command import BELOW, conclusion, was_busy

RESULT: dict[str, Any] = {
    "robots": 10,
    "links": 13,
    "moved_s": 60.0,
    "optimal_separation": 68.1138,
    "mean_estimate_error": -0.0812,
    "estimate_time": 12.8,
    "separation_error_max": 0.4,
    "separation_error_rms": 0.123,
    "separation_time": 29.5,
    "bodies_lost_s": 9.0,
    "beacons": {"concealed": 0, "heard": 1000},
}
REPORTS = [f"robot {robot}: running" for robot in range(30)]


@pytest.mark.parametrize("reports", [[], REPORTS])
def test_they_fit_below_the_last_frame_with_the_headline_last(reports: list[str]) -> None:
    lines = conclusion(RESULT, reports, Path("runs/tabletop-1"))
    assert len(lines) <= BELOW
    assert max(map(len, lines)) <= 80
    assert lines[-2] == "run directory: runs/tabletop-1"
    assert lines[-1] == "10 robots, 13 links at the end within 0.40 m of r* = 68.11 m"
    assert ("gates: 30 reports, which --verbose shows" in lines) == bool(reports)


def test_verbose_adds_every_report_of_the_gates() -> None:
    short, long = (conclusion(RESULT, REPORTS, Path("runs/x"), verbose) for verbose in (False, True))
    assert long == [*REPORTS, *short[1:]]


def test_a_team_without_links_has_no_error() -> None:
    lines = conclusion(RESULT | {"links": 0, "separation_time": None, "separation_error_rms": None}, [], Path("x"))
    assert lines[-1] == "10 robots, no links"
    assert any("rms error unknown" in line for line in lines)


@pytest.mark.parametrize(
    ("moved", "lost", "concealed", "line"),
    [
        (60.0, 0.2, 30, ""),
        (60.0, 0.2, 50, "the machine was too busy for real time: 5.0 % of the beacons came late"),
        (5.0, 0.2, 50, ""),
        (5.0, 1.4, 0, "the machine was too busy for real time: the bodies stood still for 1.4 s"),
    ],
)
def test_a_line_says_why_a_run_is_not_in_real_time(moved: float, lost: float, concealed: int, line: str) -> None:
    beacons = {"concealed": concealed, "heard": 1000}
    result = RESULT | {"moved_s": moved, "bodies_lost_s": lost, "beacons": beacons}
    assert was_busy(result) == bool(line)
    assert [text for text in conclusion(result, [], Path("x")) if "busy" in text] == [line] * bool(line)
