"""The panels of a page in a document of Bokeh, without a browser."""

import asyncio
from typing import Any

import numpy as np
import pytest

pytest.importorskip("bokeh", reason="Bokeh is not installed: pip install -e '.[web]' in a clone")

from bokeh.core.validation.check import check_integrity
from bokeh.document import Document
from bokeh.events import ButtonClick

from console.web import columns, controls, team_map
from console.web.controls import Controls
from console.web.facts import RunFacts
from console.web.feed import Feed
from console.web.page import Page
from console.web.slider import TimeSlider
from fes.errors import Rejected
from fes.protocol.report import Report
from tests.support.frames import a_report, measured
from world.config.radio import RadioConfig

PAIR = a_report([(0.0, 0.0), (60.0, 0.0)], [(0, 1)])


def shown(report: Report | None, slider: TimeSlider | None = None) -> tuple[Document, Page]:
    document, feed = Document(), Feed()
    if report is not None:
        feed.add(report)
    return document, Page(document, feed, RunFacts("main"), None, slider)


def panel(document: Document, name: str) -> Any:
    return document.get_model_by_name(name)


def test_a_page_before_the_first_report_waits() -> None:
    document, _ = shown(None)
    assert "waiting for the world" in panel(document, "header").text
    assert len(panel(document, "robots").data["x"]) == 0


def test_the_map_draws_columns_that_are_there_from_the_first_report_on() -> None:
    assert set(team_map.ROBOT) == set(columns.robots(PAIR))
    assert set(team_map.LINK) <= set(columns.lines(PAIR))


@pytest.mark.parametrize("report", [None, PAIR])
def test_a_page_breaks_no_rule_of_bokeh(report: Report | None) -> None:
    document, _ = shown(report)
    issues = check_integrity(document.models)
    assert not issues.error
    assert not issues.warning


def test_reception_is_shown_of_measured_runs_only_and_the_team_index_only_where_it_is_computed() -> None:
    document, _ = shown(PAIR)
    assert not panel(document, "reception").visible
    assert not panel(document, "index").visible
    document, _ = shown(measured(a_report([(0.0, 0.0), (60.0, 0.0)], [(0, 1)], has_team_index=True), -2.0, 3.0))
    assert panel(document, "reception").visible
    assert panel(document, "index").visible
    assert len(panel(document, "learnt").data["separation"]) > 10


def test_a_page_has_controls_only_if_it_may_send() -> None:
    document, _ = shown(PAIR)
    assert panel(document, "set") is None
    assert panel(document, "controls") is None


@pytest.mark.parametrize("field", controls.UNITS)
def test_each_control_sets_a_number_of_the_channel(field: str) -> None:
    table = RadioConfig.model_validate({"shadowing": {"deviation": 1.0}})
    value: Any = table
    for name in field.split("."):
        value = getattr(value, name)
    assert isinstance(value, float)


def test_a_press_sends_what_the_fields_hold_and_shows_the_answer() -> None:
    document, sent = Document(), list[tuple[str, Any]]()

    async def send(path: str, value: Any) -> str:
        sent.append((path, value))
        if value < 0.0:
            raise Rejected("must be greater than <0>")
        return "it is <set>"

    made = Controls(document, send)
    document.add_root(made.row)
    field, value, button, answer = (panel(document, name) for name in ("field", "value", "set", "answer"))
    field.value = "path_loss_exponent"
    for typed, text in (("2.5", "it is &lt;set&gt;"), (" -1 ", "refused: must be greater than &lt;0&gt;")):
        value.value = typed
        button._trigger_event(ButtonClick(button))
        assert button.disabled
        asyncio.run(made._request())
        assert answer.text == text
        assert not button.disabled
    assert sent == [("channel.path_loss_exponent", 2.5), ("channel.path_loss_exponent", -1)]


def test_a_slider_plays_no_further_than_what_is_known_and_can_be_moved() -> None:
    slider = TimeSlider(10.0, 0.02, 4.0)
    slider.advance(0.5, 100.0)
    assert slider.tick == 100
    slider.advance(1.0, 3.0)
    assert slider.tick == 150
    document = Document()
    document.add_root(slider.row)
    panel(document, "time").value = 1.0
    assert slider.tick == 50
    panel(document, "play").active = False
    slider.advance(1.0, 100.0)
    assert slider.tick == 50
    panel(document, "play").active = True
    slider.advance(100.0, 100.0)
    assert slider.tick == 500
    assert not panel(document, "play").active
    panel(document, "play").active = True
    assert slider.tick == 0


def test_robots_that_cut_and_robots_that_are_away_are_marked() -> None:
    line = a_report(
        [(0.0, 0.0), (60.0, 0.0), (120.0, 0.0)], [(0, 1)], alive=np.array([1, 1, 0], dtype=np.uint8),
        cutting=np.array([1]),
    )  # fmt: skip
    document, _ = shown(line)
    assert panel(document, "robots").data["marker"] == ["circle", "circle", "x"]
    assert len(set(panel(document, "robots").data["color"])) == 3
