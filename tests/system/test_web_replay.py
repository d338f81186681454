"""The page of a log in a real browser: a slider chooses the time, and each browser has its own."""

from pathlib import Path

import pytest

from console.backends import inprocess
from tests.support.browser import browser, needs_browser, page
from tests.support.commands import call, complaint
from tests.support.loop import load
from tests.support.processes import until
from world.execution.recorder import Recorder

pytestmark = [needs_browser, pytest.mark.slow]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """The log of a run of 20 s, or 1000 ticks."""
    scenario = load("pair.toml", run__duration=20)
    with Recorder(tmp_path / "run.mcap", scenario, "pair", "inprocess") as recorder:
        recorder.conclude(inprocess.run(scenario, "pair", recorder=recorder))
    return tmp_path


def test_a_log_is_played_paused_and_moved(log: Path) -> None:
    with page(log, "replay", ".", "--speed", "8") as (address, _), browser(log / "first") as window:
        window.open(address)
        until(lambda: "recorded" in window.text("header"))
        until(lambda: window.tick() == 999)
        assert "seed <b>1</b>" in window.text("header")
        until(lambda: max(window.column("curves", "time")) == pytest.approx(0.02 * 999))  # drawn once per second
        final = window.column("robots", "x")
        window.run("model('time').value = 5.0")
        until(lambda: window.tick() == 250)
        until(lambda: window.column("robots", "x") != final)
        with browser(log / "second") as second:
            second.open(address)
            until(lambda: second.tick() > 250)
            assert second.errors() == []
        assert window.tick() == 250
        window.run("model('play').active = true")
        until(lambda: window.tick() == 999)
        until(lambda: window.column("robots", "x") == final)
        assert window.errors() == []


def test_a_page_of_a_log_takes_no_other_order(log: Path) -> None:
    for words in (["--headless"], ["--all"], ["--robot", "0"]):
        line = complaint(call(log, "fes", "replay", ".", "--web", *words), "fes")
        assert line.startswith("--web shows a run: give it without --robot")
    assert complaint(call(log, "fes", "replay", ".", "--port", "0"), "fes") == "--port is that of --web"
