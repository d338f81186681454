"""The map of the dashboard: positions of robots and links."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from console.dashboard.canvas import Canvas
from fes.protocol.report import Report
from tests.support import frames
from tests.support.frames import SIZES, a_history, a_report, a_swarm, dots, find, frame, pieces, team_map


@pytest.fixture(scope="module")
def played() -> list[Report]:
    return frames.play()


def test_a_robot_to_the_east_is_drawn_to_the_right_and_one_to_the_north_above() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [80.0, 0.0, math.pi / 2], [0.0, 80.0, math.pi]])
    lines = team_map(a_report(poses[:, :2], poses=poses))
    (origin, level), (east, level_east), (north, level_north) = (find(lines, arrow) for arrow in "→↑←")
    assert east > origin
    assert level_east == level
    assert north == origin
    assert level_north < level


@pytest.mark.parametrize(("width", "height"), SIZES[:3])
def test_a_square_is_drawn_square_within_a_dot(width: int, height: int) -> None:
    corners = [(0.0, 0.0), (60.0, 0.0), (60.0, 60.0), (0.0, 60.0)]
    drawn = dots(team_map(a_report(corners, [(0, 1), (1, 2), (2, 3), (0, 3)]), width, height))
    across, up = np.ptp(drawn, axis=0)
    assert across > 20
    assert abs(across - up) <= 1


def test_the_scale_shows_the_meters_between_two_robots() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [140.0, 0.0, math.pi]])
    report = a_report(poses[:, :2], poses=poses)
    (left, _), (right, _) = (find(team_map(report), arrow) for arrow in "→←")
    bar, metres = re.findall(r"(├─*┤) (\d+) m", "\n".join(frame(a_history(report))))[0]
    # Rounding to cells: half a cell of the bar's fifteen or so, and one of the forty between the robots
    assert (right - left) * int(metres) / len(bar) == pytest.approx(140.0, rel=0.06)


def test_every_robot_of_the_paper_is_named_on_the_map(played: list[Report]) -> None:
    for report in played:
        names = re.findall(r"\d+", " ".join(team_map(report)))
        assert sorted(map(int, names)) == list(range(10))


def test_links_with_more_outage_have_fewer_dots() -> None:
    good, fair, poor, unknown = (
        len(dots(team_map(a_report([(0.0, 0.0), (90.0, 0.0)], [(0, 1)], outage=np.array([lost])))))
        for lost in (0.1, 0.2, 0.5, math.nan)
    )
    assert good > 1.5 * fair
    assert fair > 1.5 * poor > 0
    assert unknown == poor


def test_a_link_to_a_missing_robot_is_omitted_from_map_and_graph() -> None:
    report = replace(a_report([(0.0, 0.0), (9.0, 0.0)], [(0, 1)]), b=np.array([7]))
    assert "2 components (1, 1)" in "".join(frame(a_history(report)))


def test_a_dead_robot_is_shown_as_dead() -> None:
    report = replace(a_swarm(10), alive=np.array([1, 1, 1, 0, 1, 1, 1, 1, 1, 1], dtype=np.uint8))
    history = a_history(report)
    text = "\n".join(frame(history))
    assert "9/10" in text
    assert re.search(r"not alive +3\b", text)
    red = [piece.text for line in pieces(history, 100, 30) for piece in line if "red" in str(piece.style)]
    assert any("×" in text for text in red)
    assert "9/10" in red
    assert not any("→" in text for text in red)


def test_a_name_cannot_move_the_cursor() -> None:
    lines = frame(a_history(replace(a_swarm(2), scenario="a\x1b[2J\nb")), 80, 24)
    assert len(lines) == 24
    assert lines[0].startswith(r"a\x1b[2J\nb")


@pytest.mark.parametrize("end", [(70.5, 3.5), (70.2, 31.0), (9.5, 38.5), (1.5, 1.5)])
def test_a_solid_line_has_no_gap(end: tuple[float, float]) -> None:
    canvas = Canvas(40, 10, ("", "red"))
    canvas.lines(np.array([[1.5, 1.5]]), np.array([end]), np.array([1]), np.array([[1, 1]]))
    drawn = dots(["".join(segment.text for segment in line) for line in canvas.render()])
    longest = int(np.ptp(drawn, axis=0).max())
    assert len(drawn) == longest + 1
    assert longest == pytest.approx(max(end) - 1.5, abs=1.0)  # half a dot at each end
    near = np.abs(drawn[:, None] - drawn[None]).max(axis=2) <= 1  # each touches the next
    assert near.sum() == len(drawn) + 2 * longest


def test_drawing_outside_the_canvas_changes_nothing() -> None:
    canvas = Canvas(4, 2, ("", "red"))
    away = np.array([[-9.0, -9.0], [20.0, 3.0]])
    canvas.lines(away, away + 5.0, np.array([1, 1]), np.array([[1, 1], [1, 1]]))
    canvas.write(-1, 0, "x", 1)
    assert "".join(segment.text for line in canvas.render() for segment in line) == " " * 8
