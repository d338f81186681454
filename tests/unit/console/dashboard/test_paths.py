"""The paths of the robots on the map."""

import math
from dataclasses import replace

import numpy as np

from console.dashboard.history import MOST_PATHS, PLACES, ReportHistory
from fes.protocol.report import Report
from tests.support.frames import a_history, a_report, a_swarm, dots, frame, pieces

STYLE = "bright_blue"
CORNERS = [(0.0, 0.0), (100.0, 0.0), (100.0, 60.0), (0.0, 60.0)]


def moved(to: tuple[float, float], tick: int) -> Report:
    """Four robots in the corners, and one that is at `to`."""
    return a_report([*CORNERS, to], tick=tick)


def drawn(history: ReportHistory, width: int = 100, height: int = 30) -> str:
    """The marks of the paths on the map."""
    return "".join(
        piece.text for line in pieces(history, width, height)[3:] for piece in line if str(piece.style) == STYLE
    )


def test_a_robot_that_moved_east_has_a_path_to_its_west() -> None:
    history = a_history(*(moved((20.0 + k, 30.0), k) for k in range(60)))
    lines = [line[: frame(history)[2].index("Convergence")] for line in frame(history)[3:]]
    [(column, row)] = [(line.index("→4"), row) for row, line in enumerate(lines) if "→4" in line]
    path = dots(lines[: row + 2])
    assert len(path) > 10
    assert path[:, 0].max() <= 2 * column + 1  # a cell is two dots wide
    assert set(path[:, 1] // 4) <= {row - 1, row, row + 1}
    assert drawn(history)


def test_robots_at_rest_have_no_path() -> None:
    history = a_history(*(moved((50.0, 30.0), k) for k in range(60)))
    assert not drawn(history)


def test_a_slow_robot_has_a_path_too() -> None:
    slow = a_history(*(moved((20.0 + 0.02 * k, 30.0), k) for k in range(2000)))  # a thousandth of a cell per report
    assert drawn(slow)


def test_a_long_path_keeps_its_start_and_few_places() -> None:
    history = a_history(*(moved((20.0 + 0.004 * k, 30.0), k) for k in range(10_000)))
    assert len(history.paths) <= PLACES
    assert len(history.paths) >= PLACES // 2
    assert history.paths[0, 4].tolist() == [20.0, 30.0]
    assert np.all(np.diff(history.paths[:, 4, 0]) > 0.0)
    assert history.paths[-1, 4, 0] > 59.0


def test_a_robot_without_a_pose_interrupts_its_path() -> None:
    lost = moved((0.0, 0.0), 40)
    lost.poses[4] = math.nan
    history = a_history(moved((20.0, 30.0), 0), lost, moved((80.0, 30.0), 80))
    assert not drawn(history)  # no line from the last place before to the first one after


def test_more_robots_than_can_be_told_apart_have_no_paths() -> None:
    start = a_swarm(MOST_PATHS + 1)
    later = replace(start, tick=start.tick + 1, poses=start.poses + np.array([5.0, 0.0, 0.0]))
    assert not drawn(a_history(start, later), 200, 50)
    assert a_history(start, later).paths.size == 0


def test_a_new_run_begins_without_paths() -> None:
    history = a_history(moved((20.0, 30.0), 0), moved((80.0, 30.0), 50), moved((50.0, 30.0), 0))
    assert len(history.paths) == 1
    assert not drawn(history)


def test_the_title_of_the_map_names_the_paths_only_if_there_are_some() -> None:
    assert "path" in frame(a_history(moved((20.0, 30.0), 0), moved((80.0, 30.0), 50)), 160, 50)[2]
    assert "path" not in frame(a_history(moved((20.0, 30.0), 0)), 160, 50)[2]
