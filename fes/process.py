"""A process from start to exit: signals, exit codes and messages."""

import asyncio
import contextlib
import fcntl
import gc
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Coroutine, Iterator
from typing import NoReturn, TypeVar

from fes.errors import FesError, Stopped, no_memory, reason
from fes.system import output, signals

SUCCESS, FAILURE, UNMET = 0, 1, 2
"""Exit codes: success; bad configuration or run-time error; the run finished, but not as its scenario expects."""

FORCED = 130
"""Exit code after a second signal."""

T = TypeVar("T")

_received: list[list[int]] = []
"""Signals that each block of `interruptible` has received."""
_uninterrupted: list[bool] = []
"""One entry in a block of `uninterrupted`."""

Service = Callable[[], Coroutine[None, None, int]]
"""A main coroutine function, which returns the exit code."""


@contextlib.contextmanager
def loading(name: str) -> Iterator[None]:
    """Around the imports of a program: an error of FES_CORE ends it in one line, before it waits for others.

    Imports make many objects that live until the end. The garbage collector would search all of them again and again,
    for 5 to 10 % of the time of the start. So it waits, and never searches what the imports have made.
    """
    gc.disable()
    try:
        yield
        from fes.arithmetic.core import functions  # numpy comes after the handlers of signals

        functions.load()
        gc.freeze()
    except FesError as error:
        complain(name, str(error))
        raise SystemExit(error.exit_code) from None
    finally:
        gc.enable()


def run(name: str, main: Service, *, exit_with_stdin: bool = False) -> NoReturn:
    """Run the service `main` to its exit code, and end the process.

    The first signal cancels `main`, the second ends the process at once. With `exit_with_stdin` the end of
    standard input counts as a signal: a child must not outlive its parent, however that ended.
    """
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(output.Formatter("%(asctime)s %(name)s: %(message)s"))
    logging.basicConfig(level=logging.INFO, handlers=[handler])
    leave(name, main, exit_with_stdin=exit_with_stdin)


def leave(name: str, main: Service, *, exit_with_stdin: bool = False, needs_its_end: bool = False) -> NoReturn:
    """As `run`, without logging: for interactive commands.

    With `needs_its_end` a signal is a failure, because the result of `main` is missing.
    """
    try:
        code = supervise(main, exit_with_stdin=exit_with_stdin)
    except Stopped as stopped:
        code = SUCCESS  # a service that was told to stop, and stopped
        if needs_its_end:
            complain(name, str(stopped))
            code = stopped.exit_code
    except FesError as error:
        complain(name, str(error))
        code = error.exit_code
    except OSError as error:
        complain(name, reason(error))
        code = FAILURE
    except MemoryError as error:
        complain(name, no_memory(error))
        code = FAILURE
    for stream in (sys.stdout, sys.stderr):
        # The terminal may be gone, or the stream closed from the start.
        with contextlib.suppress(OSError, AttributeError):
            stream.flush()
    # A session that Zenoh could not close would block an ordinary exit forever.
    os._exit(code)


def supervise(main: Callable[[], Coroutine[None, None, T]], *, exit_with_stdin: bool = False) -> T:
    """The result of `main`, run to its end; a signal cancels it, lets it clean up, and raises Stopped.

    Afterwards signals have their previous handlers again.
    """
    with signals.restored():
        return asyncio.run(_until_stopped(main, exit_with_stdin))


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """A block without an event loop: the first signal raises Stopped, and the second ends the process at once."""
    received: list[int] = []

    def stop(number: int, frame: object) -> None:
        received.append(number)
        if len(received) > 1:
            signals.force(FORCED)
        if _uninterrupted:
            return
        raise Stopped(f"stopped by {signal.Signals(number).name}")

    with signals.restored():
        for number in signals.heard():
            signal.signal(number, stop)
        _received.append(received)
        try:
            yield
        finally:
            _received.remove(received)


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """A short block of `interruptible` at whose end Stopped is raised, if a signal has come meanwhile."""
    if not _received or _uninterrupted or threading.current_thread() is not threading.main_thread():
        yield
        return
    _uninterrupted.append(True)
    try:
        yield
    finally:
        _uninterrupted.clear()
    if _received[-1]:
        raise Stopped(f"stopped by {signal.Signals(_received[-1][0]).name}")


async def _until_stopped(main: Callable[[], Coroutine[None, None, T]], exit_with_stdin: bool) -> T:
    loop = asyncio.get_running_loop()
    received: list[str] = []

    def stop(by: str) -> None:
        received.append(by)
        if len(received) > 1:
            signals.force(FORCED)
        task.cancel(by)  # the task sees the reason

    for number in signals.heard():
        loop.add_signal_handler(number, stop, number.name)
    signals.deliver()
    if exit_with_stdin:
        try:
            loop.add_reader(sys.stdin.fileno(), lambda: _at_end_of_stdin(loop, stop))
            _wake_at_end_of_stdin()
        except (OSError, AttributeError, ValueError):
            raise FesError("--exit-with-stdin: standard input must be a pipe or a terminal") from None
    task = asyncio.ensure_future(main())
    try:
        return await task
    except asyncio.CancelledError:
        raise Stopped(f"stopped by {received[0] if received else 'a cancellation'}") from None


def _at_end_of_stdin(loop: asyncio.AbstractEventLoop, stop: Callable[[str], None]) -> None:
    if not os.read(sys.stdin.fileno(), 4096):
        loop.remove_reader(sys.stdin.fileno())
        stop("the end of standard input")


def _wake_at_end_of_stdin() -> None:
    """Let the end of standard input resume this process if it is suspended: else it would not see that end.

    Only Linux can do this.
    """
    if sys.platform == "linux" and not sys.stdin.isatty():
        stdin = sys.stdin.fileno()
        fcntl.fcntl(stdin, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(stdin, fcntl.F_SETSIG, signal.SIGCONT)
        fcntl.fcntl(stdin, fcntl.F_SETFL, fcntl.fcntl(stdin, fcntl.F_GETFL) | os.O_ASYNC)


def complain(name: str, message: str) -> None:
    """Print an error, in one line."""
    tell(f"{name}: error: {message}")


def warn(name: str, message: str) -> None:
    """Print a warning, in one line; the program continues."""
    tell(f"{name}: warning: {message}")


def tell(message: str) -> None:
    """Print a message on standard error, in one line; nothing if that is closed."""
    line = output.printable(" ".join(message.split("\n")))
    if sys.stderr is not None:  # print() would take standard output instead
        output.erase()
        with contextlib.suppress(OSError, ValueError):  # the terminal may be gone
            print(line, file=sys.stderr, flush=True)
