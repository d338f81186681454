"""The live dashboard. A view, which never slows a tick."""

import contextlib
import io
import re
import time
from pathlib import Path
from types import TracebackType
from typing import Self

from rich.console import Console, RenderableType

from console.connect import observer
from console.dashboard.frame import ReportHistory, render
from console.terminal import screen
from console.terminal.screen import Draw
from fes.errors import FesError, reason
from fes.protocol.report import Report
from fes.transport.bus import Bus

IDLE = 0.25
"""Without news the screen is drawn again after this time [s], for a terminal that was resized."""

LEAST = 12
"""Least lines of the last frame, however small the terminal, and however much comes below it."""


class Screen:
    """A terminal that shows the dashboard while the block lasts, and keeps its last frame."""

    def __init__(self, console: Console, below: int = 0) -> None:
        """`below` lines will be printed after the last frame, and are to fit under it."""
        self.history = ReportHistory()
        self._console = console
        self._below = below
        self._draw: Draw = lambda frame: None
        self._open = contextlib.ExitStack()

    def __enter__(self) -> Self:
        with contextlib.ExitStack() as stack:
            stack.callback(self._keep)
            self._draw = stack.enter_context(screen.whole(self._console))
            self.draw()
            self._open = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open.__exit__(kind, error, trace)

    def show(self, report: Report) -> None:
        """Show a report."""
        self.history.add(report)
        self.draw()

    def draw(self, silence: float = 0.0) -> None:
        """Draw what is known, at the terminal's present size, after a `silence` [s] of the world."""
        self.history.silence = silence
        self._draw(self.frame())

    def frame(self) -> RenderableType:
        """What is known, as one frame of the terminal's present size."""
        return render(self.history, self._console.width, self._console.height)

    def _keep(self) -> None:
        """Print the last frame as ordinary lines, if there was one."""
        if self.history.latest is not None:
            height = max(LEAST, self._console.height - self._below - 1)  # less one, for the shell's prompt
            with contextlib.suppress(OSError, SystemExit):  # rich raises it when the reader is gone
                self._console.print(render(self.history, self._console.width, height))


def save_picture(path: Path, frame: RenderableType, width: int, height: int, title: str) -> None:
    """Write a frame as an SVG picture; raises FesError."""
    paper = Console(record=True, file=io.StringIO(), width=width, height=height, force_terminal=True)
    paper.print(frame)
    picture = re.sub(r"@font-face\s*\{.*?\}", "", paper.export_svg(title=title), flags=re.DOTALL)  # no web fonts
    try:
        path.write_text(picture, encoding="utf-8")
    except OSError as error:
        raise FesError(f"cannot write {path}: {reason(error, with_file=False)}") from None


async def watch(bus: Bus, run: str, timeout: float, shown: Screen) -> None:
    """Show a run until its world leaves; raises Absent if none appears within `timeout` [s]."""
    heard = time.monotonic()
    async for report in observer.reports(bus, run, timeout, IDLE):
        if report is None:
            shown.draw(time.monotonic() - heard)
        else:
            heard = time.monotonic()
            shown.show(report)
