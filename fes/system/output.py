"""Text that leaves a process, on a terminal, in a pipe or in a log: any encoding, no control characters."""

import contextlib
import io
import logging
import sys
from collections.abc import Callable, Iterator

_erasers: list[Callable[[], None]] = []
"""Functions that erase a line of progress."""


def configure() -> None:
    """Let standard output and standard error print `?` for a character that their encoding does not have."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    if logging.lastResort is not None:  # for tools that configure no log
        logging.lastResort.setFormatter(Formatter("%(message)s"))


def printable(text: str) -> str:
    r"""`text` as one line without control characters: each is shown as its escape.

    >>> print(printable("a\x1b[2J\nb"))
    a\x1b[2J\nb
    """
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)


@contextlib.contextmanager
def erased(erase: Callable[[], None]) -> Iterator[None]:
    """A block in which `erase` removes a line of progress before a message of `fes.process.tell` is printed."""
    _erasers.append(erase)
    try:
        yield
    finally:
        _erasers.remove(erase)


def erase() -> None:
    """Erase the line of progress that is shown, if there is one."""
    for eraser in _erasers:
        eraser()


class Formatter(logging.Formatter):
    """Lines of a log: a message may quote a file or a peer."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802, logging's own name
        """The line of a record."""
        return printable(super().formatMessage(record))

    def formatException(self, ei: object) -> str:  # noqa: N802, logging's own name
        """The lines of a traceback."""
        return "\n".join(map(printable, super().formatException(ei).split("\n")))  # type: ignore[arg-type]
