"""One child process of `fes run`: its start, its signals, and a report of its end."""

import asyncio
import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from fes.errors import reason
from fes.system import encoding
from fes.system.output import printable
from fes.system.signals import STOP_SIGNALS

DISMISSED = "the run is over"
"""Text in the log of an agent that its world has dismissed."""

TAIL = 4096
"""Length of the part of a log that is read, at its end [bytes]."""

LONGEST = 300
"""Longest line of a log that is shown [characters]."""


@dataclass(frozen=True, eq=False)
class ManagedProcess:
    """One child process."""

    name: str
    """The program and the robots that it hosts."""
    process: asyncio.subprocess.Process
    log: Path
    """File with its standard error."""
    robots: str = ""
    """The ids of the robots that an agent hosts, in the form of its `--id`."""
    born: float = field(default_factory=time.monotonic)
    """Time of its start [s; monotonic]."""

    @property
    def runs(self) -> bool:
        """True if it has not ended."""
        return self.process.returncode is None

    @property
    def was_dismissed(self) -> bool:
        """True if an agent ended because its run was over; also if its log cannot be read."""
        try:
            return DISMISSED in self._tail()
        except OSError:
            return True

    def verdict(self) -> str:
        """Its name, its exit code or signal, and the last line of its log; never raises, also without a log."""
        code = self.process.returncode
        try:
            lines, source = self._tail().strip().splitlines(), f"its log: {self.log}"
        except OSError as error:
            lines, source = [], f"its log cannot be read: {reason(error)}"
        last, label = _shortened(lines[-1]) if lines else "", f"{self.name.split()[0]}: error: "
        if code is not None and code < 0:
            return f"{self.name} was ended by {_signal_name(-code)} ({source})"
        if code == 1 and last.startswith(label):
            return f"{self.name}: {last.removeprefix(label)}"
        return f"{self.name} ended with exit code {code}" + (f", {last}" if code and last else "") + f" ({source})"

    def signal(self, number: signal.Signals) -> None:
        """Send it a signal, unless it has ended.

        Popen is not used, because it would reap a child that has ended, and asyncio would miss its exit code.
        """
        if self.runs:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.process.pid, number)

    def _tail(self) -> str:
        with self.log.open("rb") as stream:
            stream.seek(max(0, stream.seek(0, os.SEEK_END) - TAIL))
            return stream.read().decode(errors="replace")


@dataclass(frozen=True)
class NotStarted:
    """An agent process that the operating system could not start."""

    name: str
    """The program and the robots that it should host."""
    robots: str
    """The ids of these robots."""
    reason: str

    def verdict(self) -> str:
        """Its name, and the reason."""
        return f"{self.name} cannot be started: {self.reason}"


async def start(name: str, module: str, arguments: list[str], log: Path, robots: str = "") -> ManagedProcess:
    """Start a child that ends when this process does; it appends to its `log`. Raises OSError."""
    with log.open("ab") as stream:
        # A child inherits the mask, so that no signal reaches a half-started interpreter: `fes.system.signals.hold`
        # delivers it later. No other child may start in between, so nothing is awaited before the process is created.
        signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)
        # A background job of a script ignores SIGINT. Its children must not: SIGINT ends a world.
        before = signal.getsignal(signal.SIGINT)
        if is_ignored := before == signal.SIG_IGN and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, lambda number, frame: None)
        try:
            process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-P",  # never take a folder `world` in the working directory for our package
                "-m",
                module,
                *map(encoding.as_bytes, arguments),
                "--exit-with-stdin",
                stdin=subprocess.PIPE,  # never written to: its end tells the child that this process is gone
                stdout=stream,
                stderr=stream,
                start_new_session=True,  # a Ctrl-C reaches only this process, which ends its children in order
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )
        finally:
            if is_ignored:
                signal.signal(signal.SIGINT, before)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
    return ManagedProcess(name, process, log, robots)


async def ended(children: Iterable[ManagedProcess], timeout: float) -> bool:
    """Wait up to `timeout` [s] until all children have ended; True if they have."""
    try:
        async with asyncio.timeout(timeout):
            for child in children:
                await child.process.wait()
    except TimeoutError:
        return False
    return True


def _signal_name(number: int) -> str:
    """The name of a signal, or its number if it has no name.

    >>> _signal_name(9), _signal_name(63)
    ('SIGKILL', 'signal 63')
    """
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _shortened(line: str) -> str:
    """The first LONGEST characters of a line of a log, in printable form."""
    return printable(line[:LONGEST]) + ("..." if len(line) > LONGEST else "")
