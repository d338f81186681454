"""Learning in the dashboard and the printed summary: reception, losses, and tracking of r*."""

import io
import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from console.backends import inprocess
from console.dashboard import summary, summary_tables
from fes.arrays.types import Floats
from fes.protocol.report import Report
from tests.support import loop
from tests.support.frames import a_history, a_report, a_swarm, dots, frame, measured

ROW = [(0.0, 0.0), (60.0, 0.0), (130.0, 0.0)]


def a_pair(**fields: object) -> Report:
    return a_report([(0.0, 0.0), (60.0, 0.0)], [(0, 1)], **fields)


def text(report: Report, width: int = 100, height: int = 30) -> str:
    return "\n".join(frame(a_history(report), width, height))


def chart(report: Report) -> tuple[list[str], Floats, Floats]:
    """The rows of the chart of reception, and its limits: separations [m] and receptions."""
    lines = frame(a_history(report))
    side = lines[2].index("Convergence")
    column = [line[side:] for line in lines]
    first = next(row for row, line in enumerate(column) if line.startswith("Reception")) + 1
    last = next(row for row, line in enumerate(column) if row > first and re.search(r"\d m .* m$", line.rstrip()))
    rows = [line[5:] for line in column[first:last]]
    parts = np.array([float(re.match(r" *(\d+)%", column[row])[1]) for row in (last - 1, first)]) / 100.0  # type: ignore[index]
    return rows, np.array(re.findall(r"([\d.]+) m", column[last]), dtype=float), parts


def test_only_a_measured_run_has_a_panel_of_reception() -> None:
    for width, height in ((80, 24), (100, 30), (160, 50), (300, 80), (60, 40)):
        assert "Reception" not in text(a_swarm(10), width, height)
        assert "Reception" in text(measured(a_swarm(10), -2.0, 3.0), width, height)


def test_the_learnt_curve_is_drawn_at_its_separations_and_receptions() -> None:
    report = replace(measured(a_report(ROW, [(0, 1), (1, 2)]), -1.2, 4.0), true_level=math.nan, sent=np.zeros(2))
    rows, (west, east), (south, north) = chart(report)
    drawn = dots(rows)
    separation = west + (east - west) * drawn[:, 0] / (2 * len(rows[0]) - 1)
    reception = north - (north - south) * drawn[:, 1] / (4 * len(rows) - 1)
    expected = np.exp(-math.exp(-1.2) * (separation / 75.0) ** 4)
    assert west < 60.0 < 70.0 < east
    assert len(drawn) >= 2 * len(rows[0])
    assert reception == pytest.approx(expected, abs=0.6 * (north - south) / (4 * len(rows) - 1))  # half a dot


def test_the_counted_share_of_a_link_is_a_mark_at_its_separation() -> None:
    report = measured(a_pair(sent=np.array([1000.0]), decoded=np.array([620.0])), -2.0, 3.0)
    rows, (west, east), (south, north) = chart(report)
    column, row = next((line.index("•"), row) for row, line in enumerate(rows) if "•" in line)
    assert west + (east - west) * (column + 0.5) / len(rows[0]) == pytest.approx(60.0, abs=0.6 * (east - west) / 43)
    assert north - (north - south) * (row + 0.5) / len(rows) == pytest.approx(0.62, abs=0.6 * (north - south) / 5)


def test_learnt_parameters_stand_beside_the_true_ones() -> None:
    start = measured(a_report(ROW, [(0, 1), (1, 2)]), -2.0, 3.0)
    report = replace(
        start,
        learnt_level=np.array([-2.1, -1.9]),
        learnt_exponent=np.array([2.5, math.nan]),
        true_level=-2.067,
        true_exponent=3.25,
    )
    assert "level    -2.000 (spread 0.200), true -2.067" in text(report)
    assert "exponent 2.500 (spread 0.000), true 3.250" in text(report)


def test_a_wide_table_shows_the_losses_of_a_link() -> None:
    report = a_pair(
        sent=np.array([12345.0]), decoded=np.array([9876.0]), outage=np.array([0.19]), longest_gap=np.array([17.0])
    )
    lines = text(report, 160, 50).split("\n")
    heading = next(line for line in lines if "separation  " in line and "link" in line)
    row = next(line for line in lines if "0–1" in line)
    end = lines[2].index("Convergence") if heading.startswith("link") else None  # the table is below the map
    assert heading[heading.index("link") : end].split() == [
        "link",
        "separation",
        "error",
        "estimates",
        "outage",
        "decoded",
        "sent",
        "gap",
    ]
    assert row[:end].split()[-4:] == ["19.0%", "80.0%", "12.3k", "17"]  # 9876 of 12345
    narrow = text(report, 80, 24)
    assert "outage" in narrow
    assert "decoded" in narrow
    assert " gap" not in narrow


def test_a_measured_table_has_the_learnt_beside_the_true_reception() -> None:
    report = replace(measured(a_pair(outage=np.array([0.25])), -2.0, 3.0), learnt_reception=np.array([0.801]))
    for width, height in ((80, 24), (160, 50), (300, 80)):
        assert "learnt true" in text(report, width, height)
        assert "80.1% 75.0%" in text(report, width, height)


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"mean_estimate_error": -0.3, "tracking_time": 5.9}, "-0.30 m from r*, 1 m reached in 5.9 s"),
        ({"mean_estimate_error": 12.3}, "+12.30 m from r*, 1 m not reached after 3.2 s"),
        ({"mean_estimate_error": 0.6}, "+0.60 m from r*, 1 m not held yet after 3.2 s"),
        ({"mean_estimate_error": math.nan}, "mean estimate    –"),
    ],
)
def test_the_time_of_the_mean_estimate_is_shown(fields: dict[str, float], expected: str) -> None:
    report = a_pair(tick=10_160, ticks=15_000, changed_at=200.0, **fields)
    assert expected in text(report, 200, 50)
    assert "r* 68.11 m since 200.0 s" in text(report, 200, 50)
    assert "since" not in text(replace(report, changed_at=0.0), 200, 50)


def test_a_change_of_the_channel_is_marked_where_it_happened() -> None:
    start = a_pair(disagreement=5.0)
    before = [replace(start, tick=tick) for tick in range(0, 3000, 10)]
    after = [replace(start, tick=tick) for tick in range(3000, 4000, 10)]
    jumped = a_history(*before, *(replace(report, changed_at=60.0) for report in after))  # at tick 3000
    for width, height in ((60, 20), (100, 30), (160, 50)):
        rows = [line for line in frame(jumped, width, height) if "│" in line]
        assert len(rows) >= 3
        bars = re.search("█+│█+", "\n".join(rows))
        assert bars is not None
        assert bars[0].index("│") / len(bars[0]) == pytest.approx(0.75, abs=1.0 / len(bars[0]))  # 3000 of 4000 ticks
        assert "│" not in "".join(frame(a_history(*before, *after), width, height))


def test_a_change_stays_marked_when_the_history_outgrows_its_bins() -> None:
    start = a_pair()
    history = a_history(*(replace(start, tick=k, changed_at=10.0 if k >= 500 else 0.0) for k in range(0, 5000, 7)))
    assert history.changes(45).tolist() == [4]  # 500 of 5000 ticks: a tenth


def printed(result: dict[str, Any]) -> str:
    screen = Console(width=80, file=io.StringIO())
    screen.print(summary.render(result, verbose=True))
    assert isinstance(screen.file, io.StringIO)
    return screen.file.getvalue()


def test_the_printed_summary_shows_the_tracking_of_each_optimum() -> None:
    result = inprocess.run(loop.load("pair.toml", run__duration=1), "pair")
    row = dict.fromkeys(result["tracking"][0])
    result["tracking"] = [
        {**row, "at": 0.0, "optimal_separation": 68.1138, "time_to_1m": 9.04},
        {**row, "at": 200.0, "optimal_separation": 65.5238, "bias": -0.19, "rmse": 0.257},
    ]
    lines = [line.split() for line in printed(result).split("\n")]
    assert ["from", "r*", "1", "m", "after", "bias", "rmse"] in lines  # the other columns are empty
    assert ["0.00", "s", "68.114", "9.04", "s", "–", "–"] in lines
    assert ["200.00", "s", "65.524", "–", "-0.190", "0.257"] in lines


def test_the_printed_summary_shows_the_worst_losses_and_the_total() -> None:
    result = inprocess.run(loop.load("pair.toml", run__duration=1), "pair")
    result["edges"] = [[k, k + 1, 60.0, 60.0, 60.0] for k in range(9)]
    result["radio"] = [[k, k + 1, 1000, 900 - 10 * k, 0.1, k] for k in range(9)] + [[0, 5, 1000, 0, 1.0, 1000]]
    lines = [line.split() for line in printed(result).split("\n")]
    first = lines.index(["8", "←", "9", "1,000", "820", "18.0%", "10.0%", "8"])
    assert [row[0] for row in lines[first : first + summary_tables.MAX_CONTACTS + 1]] == [
        "8",
        "7",
        "6",
        "5",
        "4",
        "all",
    ]
    assert lines[first + summary_tables.MAX_CONTACTS] == ["all", "9,000", "7,740", "14.0%", "10.0%", "8"]
    assert "0 ← 5" not in printed(result)  # a contact, but not a link


def test_the_printed_summary_omits_a_radio_without_losses() -> None:
    perfect = inprocess.run(loop.load("pair.toml", run__duration=1, channel__model="perfect"), "pair")
    assert "Beacons over" not in printed(perfect)
