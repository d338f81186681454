"""A process from start to exit: signals, exit codes, and the flags that world and agents share."""

import argparse
import asyncio
import contextlib
import fcntl
import logging
import os
import signal
import sys
from collections.abc import Callable, Coroutine, Iterator, Mapping
from typing import NoReturn, TypeVar

from fes.errors import FesError, Stopped, no_memory, reason
from fes.protocol import keys
from fes.system import output, signals
from fes.transport import identity, network_flags
from fes.transport.endpoints import Endpoints, Mode, default_endpoint

SUCCESS, FAILURE, UNMET = 0, 1, 2
"""Exit codes: success; bad configuration or run-time error; the run finished, but not as its scenario expects."""

FORCED = 130
"""Exit code after a second signal."""

YEAR = 3.2e7  # s

SLOWEST = 1e-6
"""Smallest real-time factor [simulated seconds per second]: a program can still sleep for a tick of it."""

T = TypeVar("T")

Service = Callable[[], Coroutine[None, None, int]]
"""A main coroutine function, which returns the exit code."""


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
        raise Stopped(f"stopped by {signal.Signals(number).name}")

    with signals.restored():
        for number in signals.heard():
            signal.signal(number, stop)
        yield


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


def seconds(text: str) -> float:
    """The argument of --timeout: a positive time [s], at most a year; raises ArgumentTypeError."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value <= YEAR:
        raise argparse.ArgumentTypeError(f"expects a positive time in seconds, got '{text}'")
    return value


def period(text: str) -> float:
    """The argument of --checkpoint: a time [s] from 0 to a year; raises ArgumentTypeError."""
    return 0.0 if text == "0" else seconds(text)


def real_time_factor(text: str) -> float | None:
    """The argument of --rtf: at least SLOWEST, or `max` for full speed (None); raises ArgumentTypeError."""
    if text == "max":
        return None
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not SLOWEST <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"expects 'max' or a number that is at least {SLOWEST:g}, got '{text}'")
    return value


class OneLineParser(argparse.ArgumentParser):
    """A parser that reports a bad argument in one line with exit code 1, as every other error."""

    def error(self, message: str) -> NoReturn:
        """Print the error, and end the process."""
        complain(self.prog, message)
        raise SystemExit(FAILURE)


def add_network_flags(parser: argparse.ArgumentParser) -> None:
    """Zenoh's own flags, as in its examples, and the run's name."""
    group = parser.add_argument_group("network")
    group.add_argument("-m", "--mode", choices=["router", "client", "peer"], help="Zenoh session mode")
    for flag in network_flags.ALL:
        group.add_argument(*flag.names, **flag.keywords)
    parser.set_defaults(run=keys.DEFAULT_RUN)
    parser.add_argument("--exit-with-stdin", action="store_true", help="stop when standard input ends")


def world_endpoints(flags: argparse.Namespace, access: Mapping[str, object] | None = None) -> Endpoints:
    """Endpoints of a world: a router that listens, unless the flags or the configuration file say otherwise.

    With `--keys` it speaks TLS only, to the roles that `access` names; raises FesError for an invalid certificate.
    """
    mode: Mode = flags.mode or "router"
    listen = tuple(flags.listen) or ((default_endpoint(secure=flags.keys is not None),) if mode == "router" else ())
    own = identity.security(flags.keys, identity.WORLD)
    return Endpoints(
        mode,
        tuple(flags.connect),
        listen,
        flags.config,
        tuple(flags.cfg),
        by_default=_without_flag(flags.connect, flags.listen),
        security={**own, **(access or {})} if own and mode != "client" else own,  # a client accepts no connections
    )


def agent_endpoints(flags: argparse.Namespace, timeout: float, role: str) -> Endpoints:
    """Endpoints of an agent: a client of the world's router, unless flags or configuration file say otherwise.

    With `--keys` it speaks TLS only, with the certificate of its role; raises FesError if that is invalid.
    """
    connect = tuple(flags.connect) or (default_endpoint(secure=flags.keys is not None),)
    return Endpoints(
        flags.mode or "client",
        connect,
        tuple(flags.listen),
        flags.config,
        tuple(flags.cfg),
        timeout,
        _without_flag(flags.connect, flags.listen),
        identity.security(flags.keys, role),
    )


def _without_flag(connect: list[str], listen: list[str]) -> frozenset[str]:
    """The endpoint settings for which no flag was given."""
    given = {"connect/endpoints": connect, "listen/endpoints": listen}
    return frozenset(key for key, endpoints in given.items() if not endpoints)
