"""The dashboard, read back from its frames as a person would."""

import math
import re
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from rich.cells import cell_len

from console.dashboard.history import CAPACITY, ReportHistory
from console.dashboard.panels import convergence as panels
from fes.protocol.report import Report
from tests.support import frames
from tests.support.frames import SIZES, TINY, a_history, a_report, a_swarm, bar_heights, frame, measured


@pytest.fixture(scope="module")
def played() -> list[Report]:
    return frames.play()


@pytest.mark.parametrize(("width", "height"), SIZES + TINY)
@pytest.mark.parametrize("robots", [None, 0, 1, 2, 10, 100, 1000])
def test_a_frame_has_exactly_the_requested_size(robots: int | None, width: int, height: int) -> None:
    history = ReportHistory() if robots is None else a_history(a_swarm(robots))
    lines = frame(history, width, height)
    assert [cell_len(line) for line in lines] == [width] * height


@pytest.mark.parametrize(("width", "height"), SIZES + TINY)
@pytest.mark.parametrize("robots", [2, 10, 200])
def test_a_frame_of_a_measured_run_has_exactly_the_requested_size(robots: int, width: int, height: int) -> None:
    history = a_history(replace(measured(a_swarm(robots), -2.0, 3.0), changed_at=0.1))
    lines = frame(history, width, height)
    assert [cell_len(line) for line in lines] == [width] * height


def test_a_frame_before_the_first_report_shows_that_it_waits() -> None:
    assert "waiting for the world" in "".join(frame(ReportHistory(), 80, 24))


def test_missing_numbers_are_drawn_as_missing() -> None:
    nothing = np.full(1, math.nan)
    poses = np.array([[0.0, 0.0, math.nan], [math.nan, 1.0, 0.0], [math.inf, 0.0, 0.0], [5.0, 5.0, 0.0]])
    report = a_report([(0.0, 0.0)] * 4, [(0, 1)], poses=poses, separation=nothing, outage=nothing)
    report = replace(report, disagreement=math.inf, ticks_per_s=math.nan, optimal_separation=math.nan, dt=math.nan)
    for width, height in SIZES + TINY:
        assert len(frame(a_history(report, report), width, height)) == height
    row = next(line for line in frame(a_history(report)) if "0–1" in line)
    assert row.split("0–1")[1].split()[0] == "–"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 0.0, 5e-324, -1e308, 1e308])
@pytest.mark.parametrize("spared", ["learnt_level", "learnt_reception", "separation", "nothing"])
@pytest.mark.parametrize("ticks", [100, 0], ids=["of a world", "of real robots"])
def test_a_report_of_only_extreme_numbers_is_drawn(value: float, spared: str, ticks: int) -> None:
    team = a_report([(0.0, 0.0), (60.0, 0.0), (60.0, 50.0)], [(0, 1), (1, 2)], ticks=ticks)
    start = measured(team, -2.0, 3.0)
    extreme: dict[str, Any] = {}
    for field in fields(Report):
        original = getattr(start, field.name)
        if isinstance(original, float):
            extreme[field.name] = value
        elif isinstance(original, np.ndarray) and original.dtype == np.float64 and field.name != spared:
            extreme[field.name] = np.full(original.shape, value)
    history = a_history(start, replace(start, **extreme))
    for width, height in SIZES:
        assert [cell_len(line) for line in frame(history, width, height)] == [width] * height


def test_a_team_without_links_has_no_table_of_links() -> None:
    assert "no links" in "".join(frame(a_history(a_report([(0.0, 0.0), (50.0, 0.0)]))))


def test_links_stand_in_the_order_of_their_separation_error() -> None:
    report = a_report([(0.0, 0.0), (60.0, 0.0), (160.0, 0.0), (230.0, 0.0)], [(0, 1), (1, 2), (2, 3)])
    shown = re.findall(r"\d–\d", "".join(frame(a_history(report))[3:]))
    assert shown == ["1–2", "0–1", "2–3"]  # 100, 60 and 70 m, where 68.11 m is wanted


@pytest.mark.parametrize(("width", "height"), SIZES[:3])
def test_links_that_do_not_fit_are_counted(width: int, height: int) -> None:
    report = a_swarm(100)
    text = "\n".join(frame(a_history(report), width, height)[3:])
    more = int(re.search(r"… and ([\d,]+) more", text)[1].replace(",", ""))  # type: ignore[index]
    assert len(re.findall(r"\d–\d", text)) + more == len(report.a)


@pytest.mark.parametrize("rows", [1, 2, 5])
def test_a_falling_series_has_falling_bars(rows: int) -> None:
    values = 50.0 * np.exp(-np.arange(40) / 4.0)
    heights = bar_heights(panels.bar_rows(values, *panels.log_range(values), rows))
    assert heights == sorted(heights, reverse=True)
    assert heights[0] == 8 * rows
    # A log scale makes an exponential a straight line
    assert np.diff(heights) == pytest.approx((heights[-1] - heights[0]) / 39, abs=1.0)


def test_a_falling_disagreement_has_falling_bars_in_the_frame() -> None:
    start = a_report([(0.0, 0.0), (60.0, 0.0)], [(0, 1)])
    history = a_history(*(replace(start, tick=k, disagreement=10.0 * 0.9**k) for k in range(100)))
    row = next(line for line in frame(history, 60, 20) if line.startswith("disagreement"))
    heights = bar_heights([row[len("separation error ") : -len("   295 µm")]])
    assert heights == sorted(heights, reverse=True)
    assert heights[0] == 8
    assert 1 <= heights[-1] <= 3  # 0.3 mm, on a scale that begins at 0.1 mm
    assert row.endswith(" 295 µm")  # 10 m * 0.9^99


def test_the_algebraic_connectivity_is_that_of_known_graphs() -> None:
    row = [(0.0, 0.0), (50.0, 0.0), (100.0, 0.0)]
    assert "λ₂ 1 " in "".join(frame(a_history(a_report(row, [(0, 1), (1, 2)]))))  # a path of three
    assert "λ₂ 3 " in "".join(frame(a_history(a_report(row, [(0, 1), (1, 2), (0, 2)]))))  # a triangle
    assert "2 components (2, 1)" in "".join(frame(a_history(a_report(row, [(0, 1)]))))


def test_absent_robots_do_not_count_in_the_algebraic_connectivity() -> None:
    row = [(0.0, 0.0), (50.0, 0.0), (100.0, 0.0), (150.0, 0.0)]
    alive = np.array([1, 1, 1, 0], dtype=np.uint8)
    text = "".join(frame(a_history(a_report(row, [(0, 1), (1, 2)], alive=alive))))
    assert "connected  λ₂ 1 " in text  # a path of three
    assert "components" not in text
    cut = "".join(frame(a_history(a_report(row, [(0, 1), (1, 3), (2, 3)], alive=alive))))
    assert "2 components (2, 1)  λ₂ 0 " in cut  # a link of an absent robot connects nothing
    for robots in (0, 1):
        left = np.array([robots, 0, 0, 0], dtype=np.uint8)
        alone = "".join(frame(a_history(a_report(row, [(0, 1)], alive=left))))
        assert "λ₂ 0 " not in alone
        assert "nan" not in alone


def test_a_history_stays_small_and_forgets_no_peak() -> None:
    start = a_report([(0.0, 0.0)], disagreement=0.5)
    history = a_history(*(replace(start, tick=k, disagreement=9.0 if k == 777 else 0.5) for k in range(5000)))
    held = history.series(100_000)[0]
    assert 1 + np.count_nonzero(np.diff(held)) <= 3
    assert np.isclose(held, 9.0).mean() == pytest.approx(1.0 / 625, rel=0.05)  # one bin of eight ticks in 5000
    assert 5000 // history.stride <= CAPACITY
    assert history.series(7)[0].tolist() == [0.5, 9.0, 0.5, 0.5, 0.5, 0.5, 0.5]


def test_reports_far_apart_leave_no_gaps() -> None:
    start = a_report([(0.0, 0.0)])
    history = a_history(*(replace(start, tick=tick) for tick in (1_000_000, 1_000_900, 1_500_000)))
    assert history.series(50)[0].tolist() == [2.5] * 50
    assert history.ticks[0] == pytest.approx(1_000_000, abs=history.stride)


def test_an_earlier_tick_begins_a_new_history() -> None:
    start = a_report([(0.0, 0.0)])
    history = a_history(replace(start, tick=5000, disagreement=9.0), replace(start, tick=0, disagreement=1.0))
    assert history.series(3)[0].tolist() == [1.0, 1.0, 1.0]
    assert history.ticks == (0, 0)
