"""The dashboard of a log: actions of keys, and frames."""

import io
import os
import pty
import termios
from pathlib import Path

import pytest
from rich.console import Console

from console.dashboard import frame
from console.replay import log, player
from console.replay.player import Player
from console.terminal.keyboard import END, LEFT, RIGHT, Keyboard
from tests.support import recordings
from tests.support.loop import load

DT = 0.02  # s


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> log.Log:
    """Twelve seconds of two robots."""
    path = tmp_path_factory.mktemp("player") / "run.mcap"
    recordings.record(path, load("pair.toml", run__duration=12.0))
    return log.load(path)


def settle(shown: Player) -> None:
    """Let the player catch up without the passage of time."""
    while True:
        before = shown.tick
        shown.advance(0.0)
        if shown.tick == before:
            return


def test_a_log_plays_at_its_speed_until_it_is_paused(recorded: log.Log) -> None:
    shown = Player(recorded, 2.0)
    settle(shown)
    assert shown.tick == 0
    shown.advance(0.5)
    settle(shown)
    assert shown.tick == 50  # 1 s
    shown.press("-")
    shown.advance(0.5)
    settle(shown)
    assert shown.tick == 75
    shown.press(" ")
    shown.advance(3.0)
    settle(shown)
    assert shown.tick == 75


def test_it_steps_and_seeks_and_stops_at_both_ends(recorded: log.Log) -> None:
    shown = Player(recorded, 1.0)
    seen = []
    for key in (".", RIGHT, RIGHT, RIGHT, LEFT, LEFT, ".", LEFT):
        shown.press(key)
        settle(shown)
        seen.append(shown.tick)
    assert seen == [1, 251, 501, 599, 349, 99, 100, 0]
    assert not shown.playing
    shown.press(" ")
    shown.advance(1000.0)
    settle(shown)
    assert (shown.tick, shown.playing, shown.over) == (599, False, False)
    shown.press("q")
    assert shown.over


def test_a_frame_after_a_seek_equals_the_frame_on_the_way(recorded: log.Log) -> None:
    def text(shown: Player) -> str:
        screen = Console(width=100, file=io.StringIO())
        screen.print(frame.render(shown.history, 100, 29))
        assert isinstance(screen.file, io.StringIO)
        return screen.file.getvalue()

    forward, back = Player(recorded, 1.0), Player(recorded, 1.0)
    for shown, keys in ((forward, [RIGHT]), (back, [RIGHT, RIGHT, LEFT])):
        shown.press(" ")
        for key in keys:
            shown.press(key)
            settle(shown)
    assert forward.tick == back.tick == 250
    assert text(forward) == text(back)
    assert "time 5.00 / 12.00 s" in text(forward)


def test_a_frame_has_the_size_of_the_terminal_and_names_the_keys(recorded: log.Log) -> None:
    shown = Player(recorded, 1.0)
    settle(shown)
    screen = Console(width=80, height=24, file=io.StringIO())
    screen.print(player.frame(shown, 80, 24))
    assert isinstance(screen.file, io.StringIO)
    lines = screen.file.getvalue().splitlines()
    assert len(lines) == 24
    assert "q: quit" in lines[-1]
    assert lines[-1].startswith("0.00 of 12 s ▶ 1x")


def test_keys_are_read_from_a_terminal_one_by_one_and_its_mode_is_restored() -> None:
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    with Keyboard(theirs) as keyboard:
        os.write(ours, b" \x1b[C.")
        assert keyboard.pressed(5.0) == [" ", RIGHT, "."]
        assert keyboard.pressed(0.0) == []
    assert termios.tcgetattr(theirs) == before
    with Keyboard(theirs) as keyboard:
        os.close(ours)
        assert keyboard.pressed(5.0) == [END]
    os.close(theirs)


def test_a_log_without_an_end_is_played_to_its_last_tick(recorded: log.Log, tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"

    def until_tick_100(topic: str, tick: int, payload: bytes) -> bytes | None:
        return payload if tick <= 100 else None

    recordings.rewrite(recorded.path, path, until_tick_100, ended=False)
    shown = Player(log.load(path), 1.0)
    shown.press(RIGHT)
    settle(shown)
    assert shown.tick == 100
    assert not shown.playing
