"""A log as the source of a page: executed again once, its Reports found by their tick."""

import asyncio
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from console.replay import browser, log, reexecution
from console.replay import robot_logs as of_robots
from console.replay.browser import RecordedRun
from console.web.facts import Status
from fes.errors import FesError
from fes.protocol.report import Report
from tests.support import recordings, robot_logs
from tests.support.loop import load


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> log.Log:
    """Four seconds of two robots."""
    path = tmp_path_factory.mktemp("browser") / "run.mcap"
    recordings.record(path, load("pair.toml", run__duration=4.0))
    return log.load(path)


def test_a_run_is_empty_at_first_and_has_every_tick_once_it_is_executed(recorded: log.Log) -> None:
    shown = RecordedRun(recorded)
    assert shown.report(0) is None
    assert shown.known == 0.0
    asyncio.run(shown.execute())
    assert shown.status == Status("recorded")
    assert shown.known == pytest.approx(0.02 * 199)
    assert [report.tick for report in map(shown.report, (0, 57, 199, 1000, None)) if report] == [0, 57, 199, 199, 199]
    assert shown.version == 200
    assert len(shown.history.curves()["time"]) == 200


@pytest.mark.parametrize(
    ("ended", "words"), [(None, "the log has no end"), ("a signal", "the run ended early: a signal")]
)
def test_the_page_of_a_part_of_a_run_names_the_reason(recorded: log.Log, ended: str | None, words: str) -> None:
    shown = RecordedRun(replace(recorded, ended=ended))
    asyncio.run(shown.execute())
    assert shown.status == Status(words, True)


def test_a_page_shows_no_logs_of_robots_but_the_log_of_a_run_beside_them(recorded: log.Log, tmp_path: Path) -> None:
    paths = [robot_logs.write(tmp_path / f"robot-{robot}.mcap", robot) for robot in range(2)]
    for target in (*paths, tmp_path):
        with pytest.raises(FesError, match=f"^--web shows the log of a run, not that of a robot: {target}$"):
            of_robots.refuse(target)
    of_robots.refuse(recorded.path)
    (tmp_path / "run.mcap").write_bytes(recorded.path.read_bytes())
    of_robots.refuse(tmp_path)


def test_a_long_log_keeps_some_of_its_ticks(recorded: log.Log, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(browser, "CAPACITY", 100)
    shown = RecordedRun(recorded)  # 400 robot-ticks: every fifth tick
    asyncio.run(shown.execute())
    assert shown.version == 40
    assert [report.tick for report in map(shown.report, (4, 5, 199)) if report] == [0, 5, 195]


def test_a_log_that_differs_is_shown_up_to_there_with_the_reason(
    recorded: log.Log, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shown, whole = RecordedRun(recorded), reexecution.reports(recorded)

    def broken() -> Iterator[Report]:
        yield from (next(whole) for _ in range(50))
        raise FesError("tick 50 differs")

    monkeypatch.setattr(shown, "_reports", broken())
    asyncio.run(shown.execute())
    assert shown.status == Status("tick 50 differs", True)
    assert shown.known == pytest.approx(0.02 * 49)
    assert capsys.readouterr().err == "fes: warning: tick 50 differs\n"
