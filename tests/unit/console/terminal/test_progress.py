"""A bar on a terminal that keeps its output, and nothing anywhere else."""

import io
import re
from collections.abc import Callable
from contextlib import AbstractContextManager

import pytest
from rich.console import Console

from console.terminal import counting, printing, progress
from console.terminal.screen import ERASE
from fes import process
from fes.system import signals

WIDTHS = (40, 60, 80, 160)


class Screen(io.StringIO):
    """A terminal that keeps its output."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(params=WIDTHS)
def screen(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Console:
    """The terminal of standard error, in several widths."""
    console = Console(file=Screen(), force_terminal=True, width=request.param, color_system=None)
    monkeypatch.setattr("console.terminal.printing.console", lambda stderr=False: console)
    return console


def text_of(console: Console) -> str:
    assert isinstance(console.file, Screen)
    return console.file.getvalue()


def frames(console: Console) -> list[str]:
    """The lines that were drawn, without codes."""
    lines = re.split(r"\r|\n|\x1b\[2K|\x1b\[1A|\x1b\[\?25[hl]", text_of(console))
    return [line for line in lines if line.strip()]


def test_a_bar_counts_what_it_is_told_and_takes_one_line_of_any_terminal(
    screen: Console, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "PERIOD", 0.0)
    with progress.drawn("the world and all robots, executed again", 1000, "frames") as bar:
        bar.note("12/20 runs")
        for done in (10, 250, 500):
            bar(done)
            bar._shown.refresh()
    drawn = frames(screen)
    if screen.width > 40:  # a narrow line shows the rate and the time first
        assert {part for line in drawn for part in re.findall(r"\d+%", line)} >= {"0%", "25%", "50%"}
    assert max(map(len, drawn)) <= screen.width
    assert text_of(screen).count("\n") <= 1  # the end of the bar, which is then erased
    if screen.width >= 80:
        assert "frames/s" in drawn[-1]
        assert drawn[-1].rstrip().endswith("left")
        assert "12/20 runs" in drawn[-1]


def test_a_count_between_two_updates_is_not_drawn_and_the_last_one_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "PERIOD", 1e9)
    monkeypatch.setattr(printing, "console", lambda stderr=False: Console(file=Screen(), force_terminal=True))
    with progress.drawn("counting", 10) as bar:
        bar(3)
        bar(4)
        assert bar._shown.tasks[0].completed == 3
        bar(10)
        assert bar._shown.tasks[0].completed == 10


def test_nothing_is_drawn_where_no_terminal_is(monkeypatch: pytest.MonkeyPatch) -> None:
    pipe = io.StringIO()
    monkeypatch.setattr(printing, "console", lambda stderr=False: Console(file=pipe))
    with progress.drawn("counting", 10) as bar:
        assert not bar.is_shown
        bar.note("a note")
        bar(10)
    assert pipe.getvalue() == ""


def test_a_bar_is_a_watch_of_a_work_in_parts() -> None:
    counts: list[int] = []
    first, second, third = counting.parts(counts.append, 10, 20, 5)
    for watch, done in ((first, 10), (second, 1), (second, 20), (third, 5)):
        watch(done)
    assert counts == [10, 11, 30, 35]


@pytest.mark.parametrize("kind", ["shown", "drawn", "waiting"])
def test_lines_beside_progress_are_erased_first_and_stay_in_their_stream_unwrapped(
    kind: str, screen: Console, capsys: pytest.CaptureFixture[str]
) -> None:
    line, data = "a warning " + "x" * 300, "data " + "y" * 300
    shown: dict[str, Callable[[], AbstractContextManager[object]]] = {
        "shown": lambda: progress.shown("counting", 10),
        "drawn": lambda: progress.drawn("counting"),
        "waiting": lambda: progress.waiting("counting"),
    }
    with signals.restored(), shown[kind]():
        process.warn("fes", line)
        printing.line(data)
    out, err = capsys.readouterr()
    assert (out, err) == (f"{data}\n", f"fes: warning: {line}\n")
    assert text_of(screen).count(ERASE) == 2
    assert "warning" not in text_of(screen)
    assert "data" not in text_of(screen)
