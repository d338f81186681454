"""The layout of the dashboard: panels by the proportions of the team, without an empty half."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from console.dashboard.history import ReportHistory
from console.dashboard.layout import Panel, share
from fes.protocol.report import Report
from tests.support.frames import a_history, a_report, a_swarm, frame, measured, team_map

TERMINALS = [(80, 24), (120, 40), (200, 50)]
MARGIN = 4, 2
"""Columns and lines around the robots, for their ids."""

TEAM = {"has_team_index": True, "team_index": 0.6, "team_index_target": 0.7, "cutting": np.zeros(0, dtype=np.int64)}
ROW = [(70.0 * k, 0.0) for k in range(10)]
CHAIN = [(k, k + 1) for k in range(9)]
TEAMS = {
    "a pair": a_report(ROW[:2], CHAIN[:1]),
    "a row": a_report(ROW, CHAIN),
    "a column": a_report([(y, x) for x, y in ROW], CHAIN),
    "a wide rectangle": a_report([(70.0 * (k % 4), 70.0 * (k // 4)) for k in range(8)], CHAIN[:7]),
    "a high rectangle": a_report([(70.0 * (k % 2), 70.0 * (k // 2)) for k in range(8)], CHAIN[:7]),
    "a square": a_swarm(9),
    "a square of robots that measure": measured(a_swarm(9), -2.0, 3.0),
    "a square with a team index": a_report([(70.0 * (k % 3), 70.0 * (k // 3)) for k in range(9)], CHAIN[:8], **TEAM),
    "a swarm": a_swarm(100),
}


@pytest.mark.parametrize(("width", "height"), TERMINALS)
@pytest.mark.parametrize("name", TEAMS)
def test_the_robots_take_up_more_than_half_of_the_map_both_ways(name: str, width: int, height: int) -> None:
    lines = team_map(TEAMS[name], width, height)
    drawn = [(column, row) for row, line in enumerate(lines) for column, mark in enumerate(line) if mark != " "]
    for low, high, margin, size in zip(
        np.min(drawn, axis=0), np.max(drawn, axis=0), MARGIN, (len(lines[0]), len(lines)), strict=True
    ):
        assert high - low + 1 + 2 * margin > size / 2, "\n".join(lines)


@pytest.mark.parametrize(("width", "height"), TERMINALS)
@pytest.mark.parametrize("name", TEAMS)
def test_no_column_of_panels_has_an_empty_half(name: str, width: int, height: int) -> None:
    lines = frame(a_history(TEAMS[name]), width, height)
    assert [len(line) for line in lines] == [width] * height
    side = lines[2].index("Convergence")
    below = next(row for row, line in enumerate(lines) if line.startswith("├"))
    left = [line[:side] for line in lines[below:]]
    right = [line[side:] for line in lines[2:]]
    for column in (left, right):
        blank = sum(not line.strip() for line in column)
        assert blank <= (height - 2) / 2, "\n".join(lines)


def test_a_high_team_has_a_narrower_map_than_a_wide_one() -> None:
    high, wide = (
        frame(a_history(TEAMS[name]), 200, 50)[2].index("Convergence")
        for name in ("a high rectangle", "a wide rectangle")
    )
    assert high < wide


def test_panels_stay_in_place_while_the_team_moves_a_little() -> None:
    def titles(history: ReportHistory) -> list[int]:
        return [row for row, line in enumerate(frame(history, 120, 40)) if line.startswith(("├", "Connectivity"))]

    history = a_history(TEAMS["a square"])
    before = titles(history)
    for factor in np.linspace(1.0, 1.1, 30):
        places = TEAMS["a square"].poses[:, :2] * (1.0, factor)
        history.add(a_report(places, CHAIN[:8]))
        assert titles(history) == before


@pytest.mark.parametrize(("width", "height"), [*TERMINALS, (160, 50)])
def test_the_whole_panel_of_the_team_index_is_shown(width: int, height: int) -> None:
    planned = {"slots": np.arange(9), "plans": np.zeros(9, dtype=np.int64)}
    places = [(70.0 * (k % 3), 70.0 * (k // 3)) for k in range(9)]
    for report in (a_report(places, CHAIN[:8], **TEAM, **planned), TEAMS["a square with a team index"]):
        text = "\n".join(frame(a_history(report), width, height))
        assert "Team ──" in text
        assert "index       85.7%" in text
        assert "cutting     no robot" in text
        assert ("plans       9 direct" in text) == bool(len(report.plans))


def test_a_legend_explains_the_words_where_there_is_room() -> None:
    for width, height in TERMINALS:
        text = "\n".join(frame(a_history(TEAMS["a row"]), width, height))
        assert "Legend" in text
        assert "r*  " in text
        assert "best separation" in text or "separation with the best index" in text
    assert "Legend" not in "\n".join(frame(a_history(TEAMS["a row"]), 40, 12))


heights = st.tuples(st.integers(0, 9), st.integers(0, 9), st.integers(0, 9), st.integers(0, 9))
panels = st.lists(heights.map(sorted), min_size=1, max_size=6)


@given(wanted=panels, height=st.integers(0, 40), data=st.data())
def test_panels_share_the_lines_by_their_rank(wanted: list[list[int]], height: int, data: st.DataObject) -> None:
    ranks = data.draw(st.permutations(range(len(wanted))))
    made = [
        Panel(str(rank), rank, (least, some, more, most), lambda height: [])
        for rank, (least, some, more, most) in zip(ranks, wanted, strict=True)
    ]
    sizes = share(made, height)
    first = max(range(len(made)), key=lambda index: ranks[index])
    assert sizes[first] >= made[first].heights[0]  # the most important one is always shown
    assert sum(sizes) <= max(height, sizes[first])
    for panel, size in zip(made, sizes, strict=True):
        assert size == 0 or panel.heights[0] <= size <= panel.heights[3]
    if sum(panel.heights[3] for panel in made) <= height:
        assert sizes == [panel.heights[3] for panel in made]


def test_an_error_that_needs_a_dither_period_is_announced() -> None:
    waiting = a_report(ROW[:2], CHAIN[:1], separation_error_max=math.nan)
    for width, height in TERMINALS:
        text = "\n".join(frame(a_history(waiting), width, height))
        assert "separation error  known after a dither period" in text.replace("error known", "error  known")
    known: list[Report] = [a_report(ROW[:2], CHAIN[:1]), waiting]
    assert "dither period" not in "\n".join(frame(a_history(*known), 120, 40))
