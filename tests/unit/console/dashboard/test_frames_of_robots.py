"""The dashboard of real robots: no truth is shown, and none is missed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rich.cells import cell_len

from console.measures import belief, links
from fes.protocol.report import Report
from tests.support.frames import SIZES, TINY, a_history, a_report, frame, measured, team_map


def of_robots(**fields: object) -> Report:
    """A report of three robots in a row, 60 m and 70 m apart, without a truth."""
    unknown = np.full(2, math.nan)
    report = a_report(
        [(0.0, 0.0), (60.0, 0.0), (130.0, 0.0)],
        [(0, 1), (1, 2)],
        ticks=0,
        optimal_separation=math.nan,
        mean_estimate_error=math.nan,
        separation_error_max=math.nan,
        true_level=math.nan,
        true_exponent=math.nan,
        estimate_ab=np.array([64.0, 66.0]),
        estimate_ba=np.array([66.0, math.nan]),
        outage=unknown,
        longest_gap=unknown,
        sent=np.array([100.0, 100.0]),
        decoded=np.array([90.0, 60.0]),
    )
    return replace(report, **fields)  # type: ignore[arg-type]


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_a_frame_of_robots_shows_no_truth_and_nothing_that_is_not_a_number(width: int, height: int) -> None:
    history = a_history(of_robots(), measured(of_robots(), -2.0, 3.0))
    text = "\n".join(frame(history, width, height))
    for absent in ("r*", "nan", "true", "outage", "ticks/s", "real time", "disk"):
        assert absent not in text
    assert "robots alive 3/3" in text or "alive 3/3" in text


@pytest.mark.parametrize(("width", "height"), SIZES + TINY)
def test_a_frame_of_robots_has_exactly_the_size_of_the_terminal(width: int, height: int) -> None:
    lines = frame(a_history(of_robots()), width, height)
    assert [cell_len(line) for line in lines] == [width] * height


def test_the_second_line_names_the_modes_of_the_gates_or_the_silence() -> None:
    history = a_history(of_robots())
    history.modes = "2 running, 1 stopped"
    assert "gates 2 running, 1 stopped" in frame(history)[1]
    history.silence = 4.0
    assert "silent for 4 s" in frame(history)[1]


def test_an_error_of_a_link_is_its_separation_less_the_mean_estimate_of_its_ends() -> None:
    assert links.errors(of_robots()).tolist() == [-5.0, 4.0]
    assert belief.series(of_robots()).tolist() == [2.5, 2.0, 5.0]  # the disagreement is that of the report
    assert belief.mean_estimate(of_robots()) == pytest.approx(196.0 / 3.0)
    rows = [line for line in frame(a_history(of_robots()), 120, 40) if "0–1" in line or "1–2" in line]
    assert [("-5.00" in row, "+4.00" in row) for row in rows] == [(True, False), (False, True)]


def test_links_are_colored_by_the_share_of_beacons_that_did_not_decode() -> None:
    assert belief.lost(of_robots()).tolist() == pytest.approx([0.1, 0.4])
    assert math.isnan(belief.lost(of_robots(sent=np.zeros(2), decoded=np.zeros(2)))[0])


def test_a_robot_whose_pose_is_unknown_is_not_on_the_map() -> None:
    poses = of_robots().poses.copy()
    poses[2] = math.nan
    shown = "".join(team_map(of_robots(poses=poses)))
    assert ("0" in shown, "1" in shown, "2" in shown) == (True, True, False)
