"""Progress in a terminal, in a notebook, or by a function of the caller."""

import contextlib
import html
import sys
from collections.abc import Callable, Iterator
from typing import Any

from console.terminal import printing, progress
from fes.system.output import printable

Show = Callable[[int, int], None]
"""Called with the completed ticks and all ticks of a call."""

Progress = Show | bool | None
"""None or True for a bar where one can be drawn, False for none, or a function."""


@contextlib.contextmanager
def shown(wanted: Progress, title: str, total: int) -> Iterator[Show | None]:
    """A block in which progress is shown; None where it cannot be drawn.

    A terminal is standard error. A notebook needs no widgets: the bar is HTML.
    """
    if callable(wanted):
        yield wanted
    elif wanted is False:
        yield None
    elif (shell := _notebook()) is not None:
        with _bar_of_notebook(shell, title) as show:
            yield show
    elif printing.is_screen(printing.console(stderr=True)):
        with progress.drawn(printable(title), total or None) as bar:
            yield lambda done, total: bar(done)
    else:
        yield None


def _notebook() -> Any:
    """The module IPython.display in the kernel of a notebook; None elsewhere."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    if not hasattr(shell, "kernel"):
        return None
    from IPython import display

    return display


@contextlib.contextmanager
def _bar_of_notebook(display: Any, title: str) -> Iterator[Show]:
    """A bar as HTML, which appears with the first call and disappears at the end."""
    handle: Any = None

    def show(done: int, total: int) -> None:
        nonlocal handle
        drawn = display.HTML(_bar(title, done, total))
        if handle is not None:
            handle.update(drawn)
        elif done < total:  # a call that has ended already needs no bar
            handle = display.display(drawn, display_id=True)

    try:
        yield show
    finally:
        if handle is not None:
            handle.update(display.HTML(""))


def _bar(title: str, done: int, total: int) -> str:
    """A bar in HTML.

    >>> _bar("pair", 5, 20)
    '<progress value="5" max="20"></progress> pair: 25 %'
    """
    share = f"{100 * done // max(total, 1)} %"
    return f'<progress value="{done}" max="{total}"></progress> {html.escape(printable(title))}: {share}'
