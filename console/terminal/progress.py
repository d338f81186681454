"""Progress of a command that takes longer than a second: on standard error, only if it is a terminal."""

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

    def name(self, text: str) -> None:
        """Show what is done now."""
        self._shown.update(self._task, description=printable(text))

    def note(self, text: str) -> None:
        """Show a text beside the bar."""
        self._shown.update(self._task, note=printable(text))


@contextlib.contextmanager
def bar(what: str, total: float | None = None) -> Iterator[Bar]:
    """A block that takes a while, in which a bar shows how much of `total` is done; None if that is unknown.

    Within it a signal raises Stopped, so that the cursor returns whatever ends the block.
    """
    measured = (BarColumn(), TaskProgressColumn(), _text("{task.fields[note]}"), TimeElapsedColumn())
    console = printing.console(stderr=True)
    with process.interruptible(), _shown(console, *measured, TimeRemainingColumn()) as shown:
        yield Bar(shown, what, total)


@contextlib.contextmanager
def waiting(what: str) -> Iterator[None]:
    """A block of asyncio that waits for others; a line says for `what`."""
    with _shown(printing.console(stderr=True), TimeElapsedColumn()) as shown:
        Bar(shown, what, None)
        yield


@contextlib.contextmanager
def status(console: Console, what: str) -> Iterator[Bar]:
    """A block of asyncio in which a line on this console says what is done, first `what`."""
    with _shown(console) as shown:
        yield Bar(shown, what, None)


@contextlib.contextmanager
def _shown(console: Console, *columns: ProgressColumn) -> Iterator[Progress]:
    shown = Progress(
        SpinnerColumn(SPINNER),
        _text("{task.description}"),
        *columns,
        console=console,
        disable=not printing.is_screen(console),
        transient=True,
        # Rich would wrap a warning, and move it to the stream of this console.
        redirect_stdout=False,
        redirect_stderr=False,
    )
    with screen.cursor_back(console), output.erased(lambda: screen.erase_line(console)), shown:
        yield shown


def _text(form: str) -> TextColumn:
    return TextColumn(form, markup=False)
