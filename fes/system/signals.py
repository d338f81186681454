"""Stop signals: during the imports of a program, and when a second signal ends it at once.

Python answers a SIGINT during an import with a traceback from within that module. So an entry point calls `hold`
before it imports anything heavy, and this module imports nothing heavy either.
"""

import contextlib
import os
import signal
from collections.abc import Callable, Iterator
from types import FrameType

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_cleanups: list[Callable[[], None]] = []
"""Cleanups to run before a second signal ends the process, the last one first."""


def hold(code: int, program: str = "") -> None:
    """From now on a stop signal ends this process at once with exit code `code`, until other handlers are set.

    With a `program`, one line on standard error gives its name and the signal's. A stop signal that the parent
    process blocked, so that it would not meet a half-started interpreter, is delivered now.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        if program:
            with contextlib.suppress(OSError):  # the terminal may be gone
                os.write(2, f"{program}: error: stopped by {signal.Signals(number).name}\n".encode())
        os._exit(code)

    for number in heard():
        signal.signal(number, stop)
    deliver()


def heard() -> tuple[signal.Signals, ...]:
    """The stop signals that this process was not started to ignore.

    `nohup` starts a program that ignores SIGHUP, and a script starts its background jobs so that they ignore SIGINT.
    """
    return tuple(number for number in STOP_SIGNALS if signal.getsignal(number) != signal.SIG_IGN)


def ignore() -> None:
    """From now on ignore all stop signals: the process has its result, and is about to end."""
    for number in STOP_SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def deliver() -> None:
    """Let blocked stop signals through."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)


@contextlib.contextmanager
def restored() -> Iterator[None]:
    """A block after which stop signals have their previous handlers."""
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def blocked() -> Iterator[None]:
    """A short block that no stop signal interrupts; signals that arrive meanwhile are delivered at its end."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def if_forced(clean: Callable[[], None]) -> Iterator[None]:
    """A block in which `clean` is called before a second signal ends this process at once."""
    _cleanups.append(clean)
    try:
        yield
    finally:
        _cleanups.remove(clean)


def force(code: int) -> None:
    """End this process at once, after the cleanups of `if_forced`."""
    for clean in reversed(_cleanups):
        with contextlib.suppress(Exception):  # no failure may prevent the end
            clean()
    os._exit(code)
