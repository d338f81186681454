"""Commands on a real pseudo-terminal, and their output on it."""

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time
from collections.abc import Mapping
from pathlib import Path

from tests.support.processes import PATIENCE

ENTER, LEAVE = "\x1b[?1049h", "\x1b[?1049l"
HIDE, SHOW = "\x1b[?25l", "\x1b[?25h"

POSIX = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
"""An ASCII locale that Python must not change to UTF-8."""

_CODES = re.compile(r"\x1b\[[0-9;?]*[a-zA-Z]")


class Terminal:
    """A command on a terminal of `columns` x `rows`; its standard output and error are both the terminal."""

    def __init__(
        self,
        words: list[str],
        where: Path,
        columns: int = 80,
        rows: int = 24,
        env: Mapping[str, str] | None = None,
        stdout: int | None = None,
    ) -> None:
        self._ours, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        fresh = {key: value for key, value in os.environ.items() if key not in ("COLUMNS", "LINES", "NO_COLOR")}
        self.process = subprocess.Popen(
            words,
            cwd=where,
            stdin=theirs,
            stdout=theirs if stdout is None else stdout,
            stderr=theirs,
            env={**fresh, "TERM": "xterm-256color", **(env or {})},
            start_new_session=True,
        )
        os.close(theirs)
        self.seen = b""

    @property
    def text(self) -> str:
        """All output so far."""
        return self.seen.decode(errors="replace").replace("\r\n", "\n")

    @property
    def left(self) -> str:
        """The output since the alternate screen was closed, without colors."""
        return _CODES.sub("", self.text.rpartition(LEAVE)[2])

    def wait_for(self, what: str) -> None:
        """Read until `what` is printed."""
        end = time.monotonic() + PATIENCE
        while what not in self.text:
            assert self._read(), self.text[-3000:]
            assert time.monotonic() < end, self.text[-3000:]

    def send(self, number: signal.Signals) -> None:
        """Send a signal to the command."""
        os.kill(self.process.pid, number)

    def type(self, keys: str) -> None:
        """Press keys."""
        os.write(self._ours, keys.encode())

    def end(self) -> int:
        """Read to the end; returns the exit code."""
        end = time.monotonic() + PATIENCE
        while self._read():
            if time.monotonic() > end:
                self.process.kill()
                raise AssertionError(self.text[-3000:])
        os.close(self._ours)
        return self.process.wait(PATIENCE)

    def _read(self) -> bool:
        """Read the available output; False if no more can come."""
        if not select.select([self._ours], [], [], 1.0)[0]:
            return True
        try:
            fresh = os.read(self._ours, 65536)
        except OSError:  # Linux raises it when the other end is closed
            fresh = b""
        self.seen += fresh
        return bool(fresh)


def is_restored(text: str) -> bool:
    """True if an entered alternate screen was left and the cursor is shown again."""
    return text.rfind(LEAVE) >= text.rfind(ENTER) and text.rfind(SHOW) >= text.rfind(HIDE)
