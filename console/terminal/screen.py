"""Full-screen frames on a terminal: the only module that uses rich's Live."""

import contextlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console, RenderableType
from rich.live import Live

from console.terminal.printing import is_screen
from fes.system import signals

CURSOR = "\x1b[?25h"
"""Show the cursor."""

LEAVE = f"\x1b[?1049l{CURSOR}"
"""Return to the ordinary screen, with a cursor."""

ERASE = "\r\x1b[K"
"""Return to the start of the line, and erase it."""

Draw = Callable[[RenderableType], None]


@contextmanager
def full_screen(console: Console) -> Iterator[Draw]:
    """A block in which frames are drawn on the alternate screen, which always closes at its end.

    Nothing is drawn if this is not a terminal.
    """
    if not is_screen(console):
        yield lambda frame: None
        return

    def leave() -> None:
        _write(console, LEAVE)

    live = Live(console=console, screen=True, auto_refresh=False)
    with signals.if_forced(leave):
        try:
            live.start()
            yield lambda frame: live.update(frame, refresh=True)
        finally:
            try:
                live.stop()
            except BaseException:  # a frame that failed, or a signal, may prevent the stop
                leave()
                raise


@contextmanager
def cursor_back(console: Console) -> Iterator[None]:
    """A block that may hide the cursor, which reappears even if a second signal ends the process."""
    with signals.if_forced(lambda: _write(console, CURSOR) if is_screen(console) else None):
        yield


def erase_line(console: Console) -> None:
    """On a terminal, erase the line of the cursor, and return to its start."""
    if is_screen(console):
        with contextlib.suppress(OSError):  # the terminal may be closed
            _write(console, ERASE)


def _write(console: Console, codes: str) -> None:
    console.file.write(codes)
    console.file.flush()
