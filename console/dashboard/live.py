"""The live dashboard, a passive view that never slows a tick."""

import contextlib
import io
import re
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

from rich.console import Console, RenderableType

from console.connect import observer
from console.dashboard.frame import render
from console.dashboard.history import ReportHistory
from console.terminal import screen
from console.terminal.screen import Draw
from fes.errors import FesError, reason
from fes.protocol.report import Report
from fes.transport.bus import Bus

IDLE = 0.25
"""Time without a Report after which the screen is drawn again, for a resized terminal [s]."""

LEAST = 12
"""Least height of the last frame [lines], even in a smaller terminal."""


class Screen:
    """A terminal that shows the dashboard within a block, and keeps its last frame."""

    def __init__(self, console: Console, below: int = 0, expected: str = "the world", source: str = "") -> None:
        """`below` is the number of lines printed after the last frame, which leaves room for them.

        `expected` names the program or the robots whose first report is awaited, `source` the source of the index.
        """
        self.history = ReportHistory()
        self.history.expected, self.history.source = expected, source
        self.console = console
        self._below = below
        self._draw: Draw = lambda frame: None
        self._open = contextlib.ExitStack()

    def __enter__(self) -> Self:
        with contextlib.ExitStack() as stack:
            stack.callback(self._keep)
            self._draw = stack.enter_context(screen.full_screen(self.console))
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
        """Draw the reports so far, `silence` [s] after the last sign of life of the world."""
        self.history.silence = silence
        self._draw(self.frame())

    def frame(self) -> RenderableType:
        """One frame of the reports so far, at the terminal's present size."""
        return render(self.history, self.console.width, self.console.height)

    def _keep(self) -> None:
        """Print the last frame, if any, as ordinary lines."""
        if self.history.latest is not None:
            height = max(LEAST, self.console.height - self._below - 1)  # the last line is for the shell's prompt
            with contextlib.suppress(OSError, SystemExit):  # rich raises SystemExit if the pipe is closed
                self.console.print(render(self.history, self.console.width, height))


def save_picture(path: Path, frame: RenderableType, width: int, height: int, title: str) -> None:
    """Write a frame as an SVG picture; raises FesError."""
    paper = Console(record=True, file=io.StringIO(), width=width, height=height, force_terminal=True)
    paper.print(frame)
    picture = re.sub(r"@font-face\s*\{.*?\}", "", paper.export_svg(title=title), flags=re.DOTALL)  # no web fonts
    try:
        path.write_text(picture, encoding="utf-8")
    except OSError as error:
        raise FesError(f"cannot write {path}: {reason(error, with_file=False)}") from None


@contextlib.contextmanager
def saved(shown: Screen, picture: Path | None, title: str) -> Iterator[None]:
    """A block after which the last frame is written as a picture, if a file is named."""
    try:
        yield
    finally:
        if picture is not None:
            console = shown.console
            save_picture(picture, shown.frame(), console.width, console.height, title)


async def watch(bus: Bus, run: str, timeout: float, shown: Screen) -> None:
    """Show a run until its world leaves; raises Unavailable if none appears within `timeout` [s]."""
    await follow(observer.reports(bus, run, timeout, IDLE), shown)


async def follow(reports: AsyncIterator[Report | None], shown: Screen) -> None:
    """Show reports until their end; None among them stands for a time without one."""
    last_report = time.monotonic()
    async for report in reports:
        if report is None:
            shown.draw(time.monotonic() - last_report)
        else:
            last_report = time.monotonic()
            shown.show(report)
