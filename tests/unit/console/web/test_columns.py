"""Reports as columns of a page."""

import math
from dataclasses import replace

import numpy as np
import pytest

from console.measures import links
from console.web import columns
from console.web.columns import ALIVE, AWAY, CUTTING, QUALITIES
from tests.support.frames import a_report, a_swarm, measured

SQUARE = [(0.0, 0.0), (60.0, 0.0), (60.0, 80.0), (0.0, 80.0)]
LINKS = [(0, 1), (1, 2), (2, 3)]


def test_robots_have_positions_headings_in_degrees_and_states() -> None:
    report = a_report(SQUARE, LINKS, alive=np.array([1, 1, 1, 0], dtype=np.uint8), cutting=np.array([1]))
    report.poses[0, 2] = math.pi / 2
    shown = columns.robots(report)
    assert shown["robot"] == ["0", "1", "2", "3"]
    assert shown["x"].tolist() == [0.0, 60.0, 60.0, 0.0]
    assert shown["heading"].tolist() == pytest.approx([90.0, 0.0, 0.0, 0.0])
    assert shown["state"] == [ALIVE, CUTTING, ALIVE, AWAY]
    assert shown["marker"] == ["circle", "circle", "circle", "x"]
    assert np.isfinite(shown["tail"]).tolist() == [True, True, True, False]
    assert len({shown["color"][robot] for robot in (0, 1, 3)}) == 3


def test_a_robot_without_a_pose_and_its_links_are_not_drawn() -> None:
    report = a_report(SQUARE, LINKS)
    report.poses[3, 0] = math.nan
    assert columns.robots(report)["robot"] == ["0", "1", "2"]
    assert columns.lines(report)["link"] == ["0–1", "1–2"]
    assert len(columns.table(report)["link"]) == 3


def test_links_have_their_ends_and_the_class_of_their_outage() -> None:
    report = a_report(SQUARE, LINKS, outage=np.array([0.1, 0.3, math.nan]))
    drawn = columns.lines(report)
    ends = np.column_stack([drawn[name] for name in ("x0", "y0", "x1", "y1")])
    assert ends.tolist() == [[0.0, 0.0, 60.0, 0.0], [60.0, 0.0, 60.0, 80.0], [60.0, 80.0, 0.0, 80.0]]
    assert drawn["quality"] == list(QUALITIES)
    assert drawn["separation"] == [60.0, 80.0, 60.0]


def test_all_columns_of_a_panel_have_one_length() -> None:
    for report in (a_report([]), a_report(SQUARE), a_swarm(30), measured(a_swarm(30), -2.0, 3.0)):
        for panel in (columns.robots, columns.lines, columns.table, columns.counted):
            assert len({len(values) for values in panel(report).values()}) == 1


def test_the_table_has_the_numbers_of_the_terminal() -> None:
    report = replace(measured(a_report(SQUARE, LINKS), -2.0, 3.0), sent=np.zeros(3), decoded=np.zeros(3))
    table = columns.table(report)
    assert table["error"].tolist() == links.errors(report).tolist()
    assert np.isnan(table["decoded"]).all()
    assert table["true"].tolist() == (1.0 - report.outage).tolist()
    assert table["learnt"].tolist() == report.learnt_reception.tolist()


def test_curves_of_reception_are_the_learnt_and_the_true_one() -> None:
    report = measured(a_report(SQUARE, LINKS), -1.2, 4.0)
    learnt, true = columns.curves(report)
    at = learnt["separation"]
    assert at[0] < 60.0
    assert at[-1] > 80.0
    assert learnt["reception"] == pytest.approx(np.exp(-math.exp(-1.2) * (at / 75.0) ** 4))
    assert true["reception"] == pytest.approx(np.exp(-3e-7 * at**3))
    assert [len(curve["separation"]) for curve in columns.curves(a_report([(0.0, 0.0)]))] == [0, 0]
    assert len(columns.curves(a_report(SQUARE, LINKS))[0]["separation"]) == 0  # an oracle has learnt nothing
