"""The dashboard of a recorded run: play, pause, step, seek."""

import sys
import time
from collections import deque

from rich.console import Console, Group, RenderableType
from rich.text import Text

from console.connect import index_source
from console.dashboard.frame import render
from console.dashboard.history import ReportHistory
from console.replay import reexecution
from console.replay.log import Log
from console.terminal import screen
from console.terminal.keyboard import END, LEFT, RIGHT, Keyboard
from fes import process
from fes.errors import Stopped
from fes.protocol.report import decode_report, encode_report

SEEK = 5.0
"""Length of a seek [s]."""

SPEEDS = (2.0**-6, 2.0**10)
KEYS = "space: play, pause  ←→: 5 s  .: step  +-: speed  q: quit"

_FRAME, _IDLE = 0.05, 0.25
_PATIENCE = 0.1  # s; longest execution of ticks before a frame is drawn
_CAPACITY = 2_000_000  # robot-ticks whose Reports are stored, about 130 bytes each


class Player:
    """Position in a run, and the Reports up to it; the run is executed again only as far as it is shown."""

    def __init__(self, log: Log, speed: float) -> None:
        self.dt, self.ticks = log.scenario.run.dt, log.scenario.ticks
        self.speed = speed
        self.playing = True
        self.over = False
        self.tick = -1
        """Tick currently shown."""
        self._source = index_source.of(log.scenario)
        self.history = self._new_history()
        self._wanted = 0.0
        self._stride = 1 + log.scenario.robots.number * self.ticks // _CAPACITY
        self._reports = reexecution.reports(log)
        self._stored: list[bytes] = []
        """Encoded Reports of every stride-th tick, so that a seek backward is instant."""
        self._ended = False

    def press(self, key: str) -> None:
        """Perform the action of a key."""
        if key in ("q", END):
            self.over = True
        elif key == " ":
            self.playing = not self.playing
        elif key == ".":
            self.playing = False
            self._seek((self._due() + self._stride) * self.dt)
        elif key in (LEFT, RIGHT):
            self._seek(self._wanted + (SEEK if key == RIGHT else -SEEK))
        elif key in ("+", "-"):
            low, high = SPEEDS
            self.speed = min(max(self.speed * (2.0 if key == "+" else 0.5), low), high)

    def advance(self, elapsed: float) -> None:
        """Advance by `elapsed` [s; wall clock]; a long execution continues at the next call."""
        due = self._due()
        if self.playing and self.tick >= due:  # a player behind its target catches up first
            self._wanted += elapsed * self.speed
            due = self._due()
        deadline = time.monotonic() + _PATIENCE
        while self.tick < due and time.monotonic() < deadline:
            self._show_next()
        if self.tick >= self._last:
            self.playing = False

    def _new_history(self) -> ReportHistory:
        history = ReportHistory()
        history.source = self._source
        return history

    @property
    def _last(self) -> int:
        """The last tick known to exist."""
        return (len(self._stored) - 1) * self._stride if self._ended else self.ticks - 1

    def _due(self) -> int:
        self._wanted = min(self._wanted, self._last * self.dt)
        due = int(self._wanted / self.dt + 1e-6)
        return due - due % self._stride

    def _seek(self, target_time: float) -> None:
        self._wanted = max(target_time, 0.0)
        if self._due() < self.tick:
            reports = self._stored[: self._due() // self._stride + 1]
            self.history, self.tick = self._new_history(), -1
            for _ in reports:
                self._show_next()

    def _show_next(self) -> None:
        """Show the next tick, stored or executed now."""
        index = (self.tick + self._stride) // self._stride if self.tick >= 0 else 0
        if index < len(self._stored):
            report = decode_report(self._stored[index])
        else:
            next_report = next((candidate for candidate in self._reports if candidate.tick % self._stride == 0), None)
            if next_report is None:
                self._ended = True
                self._wanted = self.tick * self.dt
                return
            report = next_report
            self._stored.append(encode_report(report))
        self.history.add(report)
        self.tick = report.tick
        if self.tick + self._stride >= self.ticks:
            deque(self._reports, maxlen=0)  # execute the rest, so that the summary is compared


def play(log: Log, console: Console, speed: float) -> None:
    """Show a log until the user quits."""
    player = Player(log, speed)
    try:
        with (
            process.interruptible(),
            Keyboard(sys.stdin.fileno()) as keyboard,
            screen.full_screen(console) as draw,
        ):
            before = time.monotonic()
            while not player.over:
                now = time.monotonic()
                player.advance(now - before)
                before = now
                draw(frame(player, console.width, console.height))
                for key in keyboard.pressed(_FRAME if player.playing else _IDLE):
                    player.press(key)
    except Stopped:
        pass  # a signal ends a view without an error
    console.print(frame(player, console.width, console.height - 1))


def frame(player: Player, width: int, height: int) -> RenderableType:
    """The dashboard, and a line with position, speed and keys."""
    position = f"{max(player.tick, 0) * player.dt:.2f} of {player.ticks * player.dt:g} s"
    state = f"{'▶' if player.playing else '⏸'} {player.speed:g}x"
    line = Text(f"{position} {state}  {KEYS}", style="reverse", no_wrap=True, overflow="ellipsis")
    line.truncate(max(1, width - 1), overflow="ellipsis", pad=True)
    return Group(render(player.history, width, height - 1), line)
