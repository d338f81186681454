"""The header of a page."""

import math
from dataclasses import replace

import numpy as np

from console.web import facts
from console.web.facts import RunFacts, Status
from tests.support.frames import a_report, measured

PAIR = a_report([(0.0, 0.0), (60.0, 0.0)], [(0, 1)], has_team_index=False)
RUNNING = Status("running")


def test_the_header_has_tick_time_seed_run_and_index() -> None:
    text = facts.header(PAIR, RunFacts("main in runs/pair-1", 7, "sampled"), RUNNING)
    for part in ("<h1>test</h1>", "tick <b>10 / 100</b>", "time <b>0.20 / 2.00 s</b>", "seed <b>7</b>"):
        assert part in text
    assert "run <b>main in runs/pair-1</b>" in text
    assert "index <b>sampled</b>" in text


def test_without_a_scenario_the_index_is_told_by_the_reports() -> None:
    assert "index <b>–</b>" in facts.header(PAIR, RunFacts("main"), RUNNING)
    assert "index <b>measured</b>" in facts.header(measured(PAIR, -2.0, 3.0), RunFacts("main"), RUNNING)
    assert "seed <b>–</b>" in facts.header(PAIR, RunFacts("main"), RUNNING)


def test_texts_of_a_run_are_never_markup() -> None:
    text = facts.header(replace(PAIR, scenario="<script>alert(1)</script>"), RunFacts("<i>&\x1b[31m"), RUNNING)
    assert "<script" not in text
    assert "<i>" not in text
    assert "\x1b" not in text
    assert "<i>" not in facts.header(None, RunFacts("<i>"), Status("<i>"))


def test_the_state_of_a_run() -> None:
    assert facts.live(0.0, False, False, "") == Status("waiting for the world")
    assert facts.live(0.5, False, True, "") == RUNNING
    assert facts.live(12.4, False, True, "") == Status("no report for 12 s", True)
    assert facts.live(99.0, True, True, "") == Status("the run is over")
    assert facts.live(99.0, False, True, "the world left") == Status("the world left", True)


def test_a_team_index_and_the_robots_that_cut_the_links() -> None:
    line = a_report([(0.0, 0.0), (60.0, 0.0), (120.0, 0.0)], [(0, 1), (1, 2)], has_team_index=True, team_index=0.5)
    text = facts.header(replace(line, team_index_target=math.nan, cutting=np.array([1])), RunFacts("main"), RUNNING)
    assert "team index <b>0.5000 of –</b>" in text
    assert "cutting <b>1</b>" in text
    apart = replace(line, a=line.a[:1], b=line.b[:1])
    assert "links <b>cut into 2 parts</b>" in facts.header(apart, RunFacts("main"), RUNNING)
