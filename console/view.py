"""The live dashboard: the only place where rich's Live is. A view, which never slows a tick."""

import io
import re
import time
from pathlib import Path
from types import TracebackType
from typing import Self

from rich.console import Console, RenderableType
from rich.live import Live

from console import observer
from console.dashboard import History, render
from fes.bus import Bus
from fes.errors import FesError, reason
from fes.report import Report

IDLE = 0.25
"""Without news the screen is drawn again after this time [s], for a terminal that was resized."""


class Screen:
    """A terminal that shows the dashboard while the block lasts."""

    def __init__(self, console: Console) -> None:
        self.history = History()
        self._console = console
        self._live = Live(console=console, screen=True, auto_refresh=False)

    def __enter__(self) -> Self:
        self._live.__enter__()
        self.draw()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.__exit__(kind, error, trace)

    def show(self, report: Report) -> None:
        """Show a report."""
        self.history.add(report)
        self.draw()

    def draw(self, silence: float = 0.0) -> None:
        """Draw what is known, at the terminal's present size, after a `silence` [s] of the world."""
        self.history.silence = silence
        self._live.update(self.frame(), refresh=True)

    def frame(self) -> RenderableType:
        """What is known, as one frame of the terminal's present size."""
        return render(self.history, self._console.width, self._console.height)


def save_picture(path: Path, frame: RenderableType, width: int, height: int, title: str) -> None:
    """Write a frame as an SVG picture; raises FesError."""
    paper = Console(record=True, file=io.StringIO(), width=width, height=height, force_terminal=True)
    paper.print(frame)
    picture = re.sub(r"@font-face\s*\{.*?\}", "", paper.export_svg(title=title), flags=re.DOTALL)  # no web fonts
    try:
        path.write_text(picture, encoding="utf-8")
    except OSError as error:
        raise FesError(f"cannot write {path}: {reason(error, with_file=False)}") from None


async def watch(bus: Bus, run: str, timeout: float, screen: Screen) -> None:
    """Show a run until its world leaves; raises Absent if none appears within `timeout` [s]."""
    heard = time.monotonic()
    async for report in observer.reports(bus, run, timeout, IDLE):
        if report is None:
            screen.draw(time.monotonic() - heard)
        else:
            heard = time.monotonic()
            screen.show(report)
