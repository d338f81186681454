"""Progress of a command that takes longer than a second, on standard error if that is a terminal."""

import contextlib
from collections.abc import Iterator

from rich.console import Console
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

from console.terminal import printing, screen
from fes import process
from fes.system import output
from fes.system.output import printable

SPINNER = "line"
"""Name of a rich spinner that every encoding can print."""


class Bar:
    """The progress bar of a command."""

    def __init__(self, shown: Progress, task: str, total: float | None) -> None:
        self._shown = shown
        self._task = shown.add_task(printable(task), total=total, note="")

    @property
    def is_shown(self) -> bool:
        """True if it is visible."""
        return not self._shown.disable

    def measure(self, total: float) -> None:
        """Set the total work."""
        self._shown.update(self._task, total=total)

    def advance(self, by: float = 1.0) -> None:
        """Add to the completed work."""
        if self.is_shown:
            self._shown.advance(self._task, by)

    def reach(self, done: float) -> None:
        """Set the completed work."""
        self._shown.update(self._task, completed=done)

    def name(self, text: str) -> None:
        """Show the present task."""
        self._shown.update(self._task, description=printable(text))

    def note(self, text: str) -> None:
        """Show text beside the bar."""
        self._shown.update(self._task, note=printable(text))


@contextlib.contextmanager
def bar(task: str, total: float | None = None) -> Iterator[Bar]:
    """A block in which a bar shows the completed part of `total`; None if the total is unknown.

    Within it a signal raises Stopped, so that the cursor always reappears.
    """
    with process.interruptible(), drawn(task, total) as shown:
        yield shown


@contextlib.contextmanager
def drawn(task: str, total: float | None = None) -> Iterator[Bar]:
    """As `bar`, without any change to signals."""
    measured = (BarColumn(), TaskProgressColumn(), _text("{task.fields[note]}"), TimeElapsedColumn())
    with _shown(printing.console(stderr=True), *measured, TimeRemainingColumn()) as shown:
        yield Bar(shown, task, total)


@contextlib.contextmanager
def waiting(task: str) -> Iterator[None]:
    """A block of asyncio that waits for other processes; a line shows `task`."""
    with _shown(printing.console(stderr=True), TimeElapsedColumn()) as shown:
        Bar(shown, task, None)
        yield


@contextlib.contextmanager
def status(console: Console, task: str) -> Iterator[Bar]:
    """A block of asyncio in which a line on this console shows the present task, first `task`."""
    with _shown(console) as shown:
        yield Bar(shown, task, None)


@contextlib.contextmanager
def _shown(console: Console, *columns: ProgressColumn) -> Iterator[Progress]:
    shown = Progress(
        SpinnerColumn(SPINNER),
        _text("{task.description}"),
        *columns,
        console=console,
        disable=not printing.is_screen(console),
        transient=True,
        # Rich would wrap warnings, and move them to the stream of this console.
        redirect_stdout=False,
        redirect_stderr=False,
    )
    with screen.cursor_back(console), output.erased(lambda: screen.erase_line(console)), shown:
        yield shown


def _text(form: str) -> TextColumn:
    return TextColumn(form, markup=False)
