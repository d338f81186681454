"""The team index on the dashboard: in every terminal in which there is room, and in no other run."""

import math

import numpy as np
import pytest

from fes.protocol.report import Report
from tests.support.frames import SIZES, TINY, a_history, a_report, frame, pieces

PLACES = [(0.0, 0.0), (70.0, 0.0), (140.0, 0.0), (210.0, 0.0)]
CHAIN = [(0, 1), (1, 2), (2, 3)]
TEAM = {
    "has_team_index": True,
    "team_index": 0.345,
    "team_index_target": 0.69,
    "delivery_after_loss": 0.4,
    "cutting": np.array([1, 2]),
}
PLANNED = {"slots": np.array([0, 2, 1, -1]), "plans": np.array([0, 0, 1, 2])}


def a_team(**fields: object) -> Report:
    return a_report(PLACES, CHAIN, **{**TEAM, **fields})


def lines_of(report: Report, width: int = 140, height: int = 45) -> list[str]:
    return frame(a_history(report), width, height)


def test_the_panel_shows_the_index_against_its_target_the_robots_that_cut_and_the_plans() -> None:
    text = "\n".join(lines_of(a_team(**PLANNED), 200))
    assert "index       50.0%  F 0.3450 of 0.6900, delivers 40.0% after a loss" in text
    assert "cutting     robots 1, 2" in text
    assert "plans       2 direct, 1 contracting, 1 without a plan; 3 with a slot" in text
    assert "F of target 50.0%" in text


def test_without_a_configuration_no_plan_is_shown() -> None:
    text = "\n".join(lines_of(a_team(cutting=np.zeros(0, dtype=np.int64))))
    assert "cutting     no robot" in text
    assert "plans" not in text
    assert "cutting     robot 3 " in "\n".join(lines_of(a_team(cutting=np.array([3]))))


def test_links_that_are_cut_already_are_shown_as_such() -> None:
    halves = a_report(PLACES, [(0, 1), (2, 3)], **{**TEAM, "cutting": np.zeros(0, dtype=np.int64)})
    assert "cutting     already cut, into 2 parts" in "\n".join(lines_of(halves))
    alive = np.array([1, 1, 0, 0], dtype=np.uint8)
    pair = a_report(PLACES, [(0, 1)], **{**TEAM, "cutting": np.zeros(0, dtype=np.int64), "alive": alive})
    assert "cutting     no robot" in "\n".join(lines_of(pair))  # robots that are not alive do not count
    bridged = a_report(PLACES, [(0, 2), (1, 2)], **{**TEAM, "alive": alive})
    assert "already cut, into 2 parts" in "\n".join(lines_of(bridged))  # nor do links to them


def test_the_header_names_the_length_that_is_sought() -> None:
    assert "r_β" in lines_of(a_team(**PLANNED), 200)[1] + lines_of(a_team(**PLANNED), 200)[2]
    assert "r_β" not in "\n".join(lines_of(a_team(), 200))


def test_absent_robots_have_no_plan() -> None:
    alive = np.array([1, 1, 0, 0], dtype=np.uint8)
    assert "plans       2 direct; 2 with a slot" in "\n".join(lines_of(a_team(**PLANNED, alive=alive)))


def test_an_index_without_a_target_is_shown_as_unknown() -> None:
    text = "\n".join(lines_of(a_team(team_index=math.nan, team_index_target=math.nan)))
    assert "index       –  F – of –" in text
    assert "F of target –" in text


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_the_index_is_shown_in_every_terminal_that_is_not_tiny(width: int, height: int) -> None:
    assert "50.0%" in "\n".join(lines_of(a_team(**PLANNED), width, height))


@pytest.mark.parametrize(("width", "height"), SIZES + TINY)
def test_a_frame_with_the_team_index_has_the_size_of_the_terminal(width: int, height: int) -> None:
    shown = lines_of(a_team(**PLANNED), width, height)
    assert len(shown) == height
    assert {len(line) for line in shown} == {width}


def test_a_run_without_the_team_index_has_the_frame_of_before() -> None:
    text = "\n".join(lines_of(a_report(PLACES, CHAIN)))
    assert "Team" not in text
    assert "F of target" not in text


def test_robots_that_cut_are_marked_on_the_map() -> None:
    for report, marked in ((a_team(), "12"), (a_team(cutting=np.array([3])), "3"), (a_report(PLACES, CHAIN), "")):
        segments = [segment for line in pieces(a_history(report), 100, 30) for segment in line]
        yellow = "".join(segment.text for segment in segments if str(segment.style) == "bold yellow")
        assert sorted(yellow.replace("→", "")) == sorted(marked)
        assert yellow.count("→") == len(marked)
