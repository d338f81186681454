"""The page of a running run in a real browser: it follows the run, changes its channel, and disturbs nothing."""

import contextlib
import signal
import subprocess
import tomllib
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from console.backends import inprocess
from tests.support import worlds
from tests.support.browser import Browser, browser, needs_browser, page
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, fes, start, until

pytestmark = [needs_browser, pytest.mark.slow]

ENDLESS = ["--duration", "100000", "--rtf", "5", "--headless"]


@contextlib.contextmanager
def running(where: Path, scenario: str, *words: str) -> Iterator["subprocess.Popen[str]"]:
    """A run in the folder `out`, announced in `runs`, and stopped at the end of the block."""
    process = start(fes("run", str(CONFIGS / f"{scenario}.toml"), *words), where)
    try:
        until(lambda: list(where.glob("runs/*/endpoint.json")))
        yield process
    finally:
        process.terminate()
        process.communicate(timeout=PATIENCE)


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


def attached(where: Path, run: worlds.Run) -> contextlib.AbstractContextManager[tuple[str, "subprocess.Popen[str]"]]:
    """The page of a run whose world may still be starting."""
    return page(where, "view", "-e", run.endpoint, "--timeout", str(PATIENCE))


def shows(shown: Browser, name: str, text: str) -> bool:
    """True if a Div of a page has a text."""
    return text in shown.text(name)


def progress(shown: Browser) -> None:
    """Wait until a page shows a later tick than now."""
    before = shown.tick()
    until(lambda: shown.tick() > max(0, before))


def test_robots_move_curves_grow_and_a_control_changes_the_channel(tmp_path: Path, window: Browser) -> None:
    with running(tmp_path, "measured", *ENDLESS), page(tmp_path, "view") as (address, _):
        window.open(address)
        until(lambda: len(window.column("robots", "x")) == 10)
        before, bins = window.column("robots", "x"), len(window.column("curves", "time"))
        until(lambda: window.column("robots", "x") != before)
        until(lambda: len(window.column("curves", "time")) > bins and window.column("counted", "learnt"))
        until(lambda: len(window.column("paths", "x")) > 30)
        assert "index <b>measured</b>" in window.text("header")
        assert "seed <b>1</b>" in window.text("header")
        assert "r* <b>68.11 m</b>" in window.text("header")
        until(lambda: set(window.column("table", "link")) == set(window.column("links", "link")))
        window.element("input[type=text]").send_keys("5e6")
        window.element("button.bk-btn-primary").click()
        until(lambda: "channel.reference_snr = 5000000.0 from tick" in window.text("answer"))
        until(lambda: "r* <b>65.52 m</b>" in window.text("header"))
        scenario = tmp_path / "runs/measured-1/scenario.toml"
        [event] = until(lambda: tomllib.loads(scenario.read_text("utf-8")).get("event"))
        assert event["set"] == {"channel.reference_snr": 5e6}
        until(lambda: window.column("changes", "time"))
        assert all(name.startswith(address) for name in window.resources() if name.startswith("http"))
        assert window.errors() == []


def test_a_control_shows_the_reason_of_a_refusal(tmp_path: Path, window: Browser) -> None:
    with running(tmp_path, "pair", *ENDLESS), page(tmp_path, "view") as (address, _):
        window.open(address)
        for typed, answer in (("-1", "must be greater than 0"), ("<b>x", "&lt;b&gt;x")):
            field = window.element("input[type=text]")
            field.clear()
            field.send_keys(typed)
            window.element("button.bk-btn-primary").click()
            until(partial(shows, window, "answer", answer))
            assert window.text("answer").startswith("refused: ")
        progress(window)
        assert window.errors() == []


def test_the_table_is_sorted_by_a_click_and_stays_so(tmp_path: Path, window: Browser) -> None:
    with running(tmp_path, "paper", *ENDLESS), page(tmp_path, "view") as (address, _):
        window.open(address)
        until(lambda: window.column("table", "link"))
        headings = "return [...find(document, '.slick-header-columns').querySelectorAll('.slick-header-column')]"
        heading = next(cell for cell in until(lambda: window.run(headings)) if "sent" in cell.text)
        heading.click()
        first = "const cell = find(document, '.slick-row .slick-cell'); return cell && cell.textContent"
        ascending = window.run(first)
        heading.click()
        until(lambda: window.run("return find(document, '.slick-sort-indicator-desc') !== null"))
        progress(window)
        progress(window)
        assert ascending
        assert window.run("return find(document, '.slick-sort-indicator-desc') !== null")
        assert window.errors() == []


def test_the_table_shows_the_numbers_of_the_latest_report(tmp_path: Path, window: Browser) -> None:
    rows = "const row = find(document, '.slick-row'); return row && row.textContent"
    with running(tmp_path, "pair", *ENDLESS), page(tmp_path, "view") as (address, _):
        window.open(address)
        first = until(lambda: window.run(rows))
        progress(window)
        until(lambda: window.run(rows) != first)
        assert len(window.column("table", "link")) == 1
        assert window.errors() == []


def test_two_browsers_one_of_which_leaves_and_returns(tmp_path: Path, window: Browser) -> None:
    with running(tmp_path, "pair", *ENDLESS), page(tmp_path, "view") as (address, _):
        window.open(address)
        with browser(tmp_path / "second") as second:
            second.open(address)
            progress(window)
            progress(second)
            assert second.errors() == []
        progress(window)
        with browser(tmp_path / "third", (800, 600)) as third:
            third.open(address)
            progress(third)
            progress(window)
            assert third.errors() == []
        assert window.errors() == []


def test_a_run_that_ends_has_the_digest_of_a_run_without_a_page_and_its_last_state_stays(
    tmp_path: Path, window: Browser
) -> None:
    expected = inprocess.run(load("pair.toml", run__duration=worlds.DURATION), "pair")["digest"]
    last = round(worlds.DURATION / 0.02) - 1
    with worlds.under_way(tmp_path, "pair.toml") as run, attached(tmp_path, run) as (address, _):
        window.open(address)
        assert "waiting for the world" in window.text("header")
        for robot in range(2):  # the run begins after the page is open
            run.join(robot)
        until(lambda: "the run is over" in window.text("header"))
        assert run.finish()["digest"] == expected
        until(lambda: window.tick() == last)
        with browser(tmp_path / "late") as late:
            late.open(address)
            assert late.tick() == last
            assert len(late.column("curves", "time")) > 10
            assert late.errors() == []
        assert window.errors() == []


def test_a_world_that_is_killed_and_resumed(tmp_path: Path, window: Browser) -> None:
    with worlds.under_way(tmp_path, "pair.toml", 100000.0) as run:
        for robot in range(2):
            run.join(robot)
        with attached(tmp_path, run) as (address, _):
            window.open(address)
            progress(window)
            run.end(signal.SIGKILL)
            killed = window.tick()
            until(lambda: "no report for" in window.text("header"))
            run.start("--resume", str(run.out))
            until(lambda: window.tick() > killed)
            until(lambda: "running" in window.text("header"))
            times = window.column("curves", "time")
            assert times == sorted(set(times))
            assert window.errors() == []
