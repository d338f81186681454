"""Lines, tables and frames on a terminal or in a pipe. Data is never markup, and never moves the cursor."""

from rich.console import Console, RenderableType
from rich.text import Text

from fes.system import output
from fes.system.output import printable


def console(stderr: bool = False) -> Console:
    """A console on standard output or standard error, on which brackets and colons are text."""
    return Console(stderr=stderr, markup=False, emoji=False, highlight=False)


def is_screen(screen: Console) -> bool:
    """True if frames and bars can be drawn: on a terminal that can move its cursor, even with FORCE_COLOR."""
    return screen.file.isatty() and not screen.is_dumb_terminal


def line(text: object) -> None:
    """Print one line of data on standard output: printable, not wrapped, without markup; above a line of progress."""
    output.erase()
    print(printable(str(text)))


def cell(text: object, style: str = "") -> Text:
    """Data as a cell of a table."""
    return Text(printable(str(text)), style)


def show(screen: Console, renderable: RenderableType) -> None:
    """Print tables without cropping."""
    screen.print(renderable, crop=False)
