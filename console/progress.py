"""Progress of a command that takes longer than a second: on standard error, only if it is a terminal."""

import contextlib
from collections.abc import Iterator

from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from console import printing, screen
from fes import process
from fes.output import printable

SPINNER = "line"
"""Name of a rich spinner that every encoding can print."""


class Bar:
    """The progress bar of a command."""

    def __init__(self, shown: Progress, what: str, total: float | None) -> None:
        self._shown = shown
        self._task = shown.add_task(printable(what), total=total, note="")

    @property
    def is_shown(self) -> bool:
        """True if it is visible."""
        return not self._shown.disable

    def measure(self, total: float) -> None:
        """Set the work that is to be done."""
        self._shown.update(self._task, total=total)

    def advance(self, by: float = 1.0) -> None:
        """Add to the work that is done."""
        if self.is_shown:
            self._shown.advance(self._task, by)

    def reach(self, done: float) -> None:
        """Set the work that is done so far."""
        self._shown.update(self._task, completed=done)

    def note(self, text: str) -> None:
        """Show a text beside the bar."""
        self._shown.update(self._task, note=printable(text))


@contextlib.contextmanager
def bar(what: str, total: float | None = None) -> Iterator[Bar]:
    """A block that takes a while, in which a bar shows how much of `total` is done; None if that is unknown.

    Within it a signal raises Stopped, so that the cursor returns whatever ends the block.
    """
    measured = (BarColumn(), TaskProgressColumn(), _text("{task.fields[note]}"), TimeElapsedColumn())
    with process.interruptible(), _shown(*measured, TimeRemainingColumn()) as shown:
        yield Bar(shown, what, total)


@contextlib.contextmanager
def waiting(what: str) -> Iterator[None]:
    """A block of asyncio that waits for others; a line says for `what`."""
    with _shown(TimeElapsedColumn()) as shown:
        Bar(shown, what, None)
        yield


@contextlib.contextmanager
def _shown(*columns: ProgressColumn) -> Iterator[Progress]:
    console = printing.console(stderr=True)
    shown = Progress(
        SpinnerColumn(SPINNER),
        _text("{task.description}"),
        *columns,
        console=console,
        disable=not printing.is_screen(console),
        transient=True,
    )
    with screen.cursor_back(console), shown:
        yield shown


def _text(form: str) -> TextColumn:
    return TextColumn(form, markup=False)
