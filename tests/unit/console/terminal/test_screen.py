"""The alternate screen always closes."""

import io
import os
from typing import Any

import pytest
from rich.console import Console

from console.dashboard import live
from console.dashboard.live import Screen
from console.terminal import screen
from fes.system import signals
from tests.support.frames import a_report
from tests.support.terminals import ENTER, LEAVE, SHOW, is_restored


class Tty(io.TextIOWrapper):
    """A terminal as far as a program can see, that keeps what was written."""

    def __init__(self, encoding: str = "utf-8") -> None:
        self.kept = io.BytesIO()
        super().__init__(self.kept, encoding=encoding, write_through=True)

    def isatty(self) -> bool:
        return True

    @property
    def text(self) -> str:
        return self.kept.getvalue().decode(self.encoding)


def on(tty: Tty) -> Console:
    return Console(file=tty, force_terminal=True, width=80, height=24, _environ={"TERM": "xterm"})


def fail(*_: object) -> Any:
    raise ZeroDivisionError


@pytest.mark.parametrize("when", ["at first", "later"])
def test_the_screen_is_left_after_any_failure_in_drawing(when: str, monkeypatch: pytest.MonkeyPatch) -> None:
    tty = Tty()
    if when == "at first":
        monkeypatch.setattr(live, "render", fail)

    def show() -> None:
        with Screen(on(tty)) as shown:
            monkeypatch.setattr(live, "render", fail)
            shown.show(a_report([(0.0, 0.0)]))

    with pytest.raises(ZeroDivisionError):
        show()
    assert ENTER in tty.text
    assert is_restored(tty.text)


def test_the_screen_is_left_after_a_frame_that_cannot_be_encoded() -> None:
    tty = Tty("ascii")  # refuses, as no entry point has configured it
    with pytest.raises(UnicodeEncodeError), screen.full_screen(on(tty)) as draw:
        draw("→")
    assert ENTER in tty.text
    assert is_restored(tty.text)


def test_a_second_signal_leaves_the_screen_too(monkeypatch: pytest.MonkeyPatch) -> None:
    codes: list[int] = []
    monkeypatch.setattr(os, "_exit", codes.append)
    tty = Tty()
    with screen.full_screen(on(tty)) as draw:
        draw("a frame")
        signals.force(130)
        assert codes == [130]
        assert tty.text.endswith(f"{LEAVE}{SHOW}")
    before = tty.text
    signals.force(130)
    assert tty.text == before  # it is left only once
