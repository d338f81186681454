"""Progress of a command that takes longer than a second, on standard error if that is a terminal.

`with shown("drawing", 50, "frames") as watch: ...` draws a bar with rate and remaining time. The block calls
`watch(done)` with the number of completed units. Without a terminal it draws nothing.
"""

import contextlib
import time
from collections.abc import Iterator

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    Task,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Column
from rich.text import Text

from console.terminal import formatting, printing, screen
from fes import process
from fes.system import output
from fes.system.output import printable

SPINNER = "line"
"""Name of a rich spinner that every encoding can print."""

PERIOD = 0.1
"""Shortest time between two updates of a bar [s]; counts in between are not drawn."""

WIDEST = 40
"""Largest width of a bar [columns]."""


class Bar:
    """A bar, which is called with the completed work: a `console.terminal.counting.Watch`."""

    def __init__(self, shown: Progress, task: str, total: float | None) -> None:
        self._shown = shown
        self._total = total
        self._task = shown.add_task(printable(task), total=total, note="")
        self._updated = -PERIOD

    def __call__(self, done: float) -> None:
        """Show the completed part `done` of the total; a call soon after another draws nothing."""
        now = time.monotonic()
        if now - self._updated >= PERIOD or done == self._total:
            self._updated = now
            self._shown.update(self._task, completed=done)

    @property
    def is_shown(self) -> bool:
        """True if it is visible."""
        return not self._shown.disable

    def name(self, text: str) -> None:
        """Show the present task."""
        self._shown.update(self._task, description=printable(text))

    def note(self, text: str) -> None:
        """Show text beside the bar."""
        self._shown.update(self._task, note=printable(text))


@contextlib.contextmanager
def shown(task: str, total: float | None = None, unit: str = "ticks") -> Iterator[Bar]:
    """A block in which a bar shows the completed part of `total`; None if the total is unknown.

    Within it a signal raises Stopped, so that the cursor always reappears.
    """
    with process.interruptible(), drawn(task, total, unit) as bar:
        yield bar


@contextlib.contextmanager
def drawn(task: str, total: float | None = None, unit: str = "ticks") -> Iterator[Bar]:
    """As `shown`, without any change to signals."""
    if total is None or total == 1:  # one unit has no rate
        columns: tuple[ProgressColumn, ...] = (_text("{task.fields[note]}"), TimeElapsedColumn())
    else:
        columns = (_Bar(), TaskProgressColumn(), _text("{task.fields[note]}"), Rate(unit), Remaining())
    with _drawn(printing.console(stderr=True), *columns) as shown:
        yield Bar(shown, task, total)


@contextlib.contextmanager
def waiting(task: str) -> Iterator[None]:
    """A block of asyncio that waits for other processes; a line shows `task`."""
    with drawn(task):
        yield


class Rate(ProgressColumn):
    """Units per second, empty until it is known."""

    def __init__(self, unit: str) -> None:
        self._unit = unit
        super().__init__(Column(no_wrap=True))

    def render(self, task: Task) -> Text:
        """The rate of a task, such as '12.3k ticks/s'."""
        return Text("" if task.speed is None else rate(task.speed, self._unit))


class Remaining(TimeRemainingColumn):
    """Time that the rest will take at the present rate."""

    def __init__(self) -> None:
        super().__init__(table_column=Column(no_wrap=True))

    def render(self, task: Task) -> Text:
        """The remaining time of a task, such as '0:00:12 left'."""
        return Text.assemble(super().render(task), " left")


def rate(speed: float, unit: str) -> str:
    """Units per second, in about three digits.

    >>> rate(12_345.6, "ticks"), rate(3.21, "figures")
    ('12.3k ticks/s', '3.2 figures/s')
    """
    return f"{formatting.count(speed) if speed >= 10 else formatting.number(speed, '.1f')} {unit}/s"


class _Task(ProgressColumn):
    """The name of the work, shortened on a narrow terminal, since the line must not wrap."""

    def __init__(self) -> None:
        super().__init__(Column())

    def render(self, task: Task) -> Text:
        return Text(task.description, no_wrap=True, overflow="ellipsis")


class _Bar(BarColumn):
    """A bar that is shorter on a narrow terminal, where the text beside it needs the room."""

    def __init__(self) -> None:
        super().__init__(None, table_column=Column(ratio=1, max_width=WIDEST))


@contextlib.contextmanager
def _drawn(console: Console, *columns: ProgressColumn) -> Iterator[Progress]:
    drawing = Progress(
        SpinnerColumn(SPINNER),
        _Task(),
        *columns,
        console=console,
        disable=not printing.is_screen(console),
        transient=True,
        # Rich would wrap warnings, and move them to the stream of this console.
        redirect_stdout=False,
        redirect_stderr=False,
    )
    with screen.cursor_back(console), output.erased(lambda: screen.erase_line(console)), drawing:
        yield drawing


def _text(form: str) -> TextColumn:
    return TextColumn(form, markup=False)
