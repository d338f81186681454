"""Errors in the words of the Python interface, one line each."""

import contextlib
import re
from collections.abc import Iterable, Iterator

from fes.errors import FesError, no_memory, reason
from fes.extension import registry

NAMES = {
    "--backend processes": "backend='processes'",
    "--no-record": "out=None",
    "--scheduler": "scheduler",
    "--axis": "axes",
    "--jobs": "jobs",
    "--seeds": "seeds",
    "--set": "overrides",
    "--use": "use",
    "--out": "out",
    "--rtf": "rtf",
    "fes sweep makes": "fes.sweep makes",
    "the same command": "the same call",
}
"""Words of the commands, and the words of the Python interface that replace them."""

_WORDS = re.compile("|".join(map(re.escape, NAMES)))


def allow(use: Iterable[str]) -> None:
    """Import modules, and allow their extensions in this process; raises FesError."""
    for module in [use] if isinstance(use, str) else use:
        registry.use(module)


@contextlib.contextmanager
def checked() -> Iterator[None]:
    """A block whose errors a person can act on are FesErrors, and name arguments instead of flags.

    >>> with checked():
    ...     raise FesError("--set expects a table")
    Traceback (most recent call last):
    fes.errors.FesError: overrides expects a table
    """
    try:
        yield
    except FesError as error:
        error.args = (_WORDS.sub(lambda match: NAMES[match[0]], str(error)),)
        raise
    except OSError as error:
        raise FesError(reason(error)) from error
    except MemoryError as error:
        raise FesError(no_memory(error)) from error
