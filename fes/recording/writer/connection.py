"""The run's side of the writer of a log: it starts that process, gives it each tick, and reports its failure.

A thread hands the frames over, several at once, so that a tick waits for no pipe. It takes Python's lock for some
microseconds, a few times per second. Signals do not reach it, so an interrupted run leaves no frame half sent.
"""

import contextlib
import math
import os
import queue
import select
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from pathlib import Path
from typing import Any

from fes.errors import FesError, reason
from fes.recording import hashed_file
from fes.recording.writer import frames
from fes.system import signals

BATCH = 1 << 18
"""Frames are handed over when they hold this much [bytes] ..."""

PERIOD = 0.1
"""... or at least once in this time [s]: a run that is killed loses these frames."""

BACKLOG = 1 << 20
"""A run waits while the writer is this far behind [bytes], beside one tick and the pipe."""

PATIENCE = 60
"""Longest time in which the writer makes no progress [s]. The time of a suspended machine does not count."""

_PAUSE = 0.002
_PIECE = 1 << 16

_START = "import sys; sys.path[:] = sys.argv[4:]; from fes.recording.writer.process import main; main()"
"""The writer imports what this process imports, also in a notebook that extends `sys.path`."""


class LogWriter:
    """A log that a process of its own writes; raises FesError, once, if it cannot be written."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._frames = deque[bytes]()
        self._given = self._handed = self._woken = 0
        self._wake = queue.SimpleQueue[bool]()  # its methods can be interrupted at any place
        self._is_lost = self._is_over = False
        self._stuck_for: float | None = None
        self._requests = 0
        self._splitter = frames.Splitter()
        try:
            self._file = open(path, "wb", buffering=0, opener=hashed_file.append)  # noqa: SIM115
        except OSError as error:
            raise FesError(f"cannot write {path}: {reason(error, with_file=False)}") from None
        try:
            self._process, self._answers = _start(path, self._file.fileno())
        except OSError as error:
            self._file.close()
            raise FesError(f"cannot start the process that writes {path}: {reason(error)}") from None
        self._thread = threading.Thread(target=self._hand_over, name="log", daemon=True)
        self._thread.start()

    @property
    def fileno(self) -> int:
        """The number of the open file."""
        return self._file.fileno()

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid

    def write(self, tick: int, time: int, messages: list[Any]) -> None:
        """Add the messages of a tick at a simulated time [ns]; they reach the file within two seconds."""
        self._give(frames.pack(0, "write", tick, time, messages), PATIENCE)

    def offer(self, tick: int, time: int, messages: list[Any]) -> bool:
        """Add messages as `write` does, and never wait: False where the writer is too far behind, or has ended.

        Then nothing is added.
        """
        if self._is_over or self._is_lost or self._given - self._handed > BACKLOG:
            return False
        self._put(frames.pack(0, "write", tick, time, messages))
        return True

    @property
    def is_lost(self) -> bool:
        """True once the writer has ended before its time; `failure` has the reason."""
        return self._is_lost or self._is_over

    def failure(self) -> FesError:
        """The error that ended a writer that is lost; it may wait for the end of that process."""
        return self._failure()

    def position(self) -> tuple[int, str]:
        """Close the chunk; returns the size of the file [bytes], and the SHA-256 of all its bytes."""
        size, sha256 = self._ask("position")
        return size, sha256

    def copy(self, path: Path, size: int) -> None:
        """Copy all messages in the first `size` bytes of another log, and verify the copy."""
        try:
            self._ask("copy", str(path), size, patience=math.inf)
        except BaseException:
            if not self._is_over:  # it was interrupted
                self._process.kill()
                self._end()
            raise

    def finish(self, ended: dict[str, str], patience: float | None = None) -> str | None:
        """Close the file with its summary, after at most `patience` [s] without progress, by default PATIENCE.

        Returns damage by other programs, in words.
        """
        if self._is_over:
            return None
        try:
            loss: str | None = self._ask("finish", ended, patience=patience)
            return loss
        finally:
            if not self._is_over:  # a failure has ended it
                self._end()

    def _give(self, frame: bytes, patience: float) -> None:
        """Let the thread hand over a frame, as soon as the writer is not too far behind; `patience` [s]."""
        if self._is_over:
            return  # the error was raised before
        stalled, before = 0.0, self._handed
        while self._given - self._handed > BACKLOG and not self._is_lost:
            time.sleep(_PAUSE)
            stalled = stalled + _PAUSE if self._handed == before else 0.0
            before = self._handed
            if stalled > patience:
                self._kill(patience)
        if self._is_lost:
            raise self._failure()
        self._put(frame)

    def _put(self, frame: bytes) -> None:
        self._frames.append(frame)
        self._given += len(frame)
        if self._given - self._woken > BATCH:
            self._woken = self._given
            self._wake.put(True)

    def _ask(self, method: str, *arguments: Any, patience: float | None = None) -> Any:
        """The writer's answer to a request, after all frames so far; `patience` [s] is PATIENCE by default."""
        patience = PATIENCE if patience is None else patience
        if self._is_over:
            raise self._failure()
        self._requests += 1
        self._give(frames.pack(self._requests, method, *arguments), min(patience, PATIENCE))
        self._wake.put(True)
        stalled, before = 0.0, self._handed
        while stalled <= patience:
            for request, result in self._received(10 * PERIOD):
                if request == self._requests:  # else it answers a request that was interrupted
                    return result
            stalled = stalled + 10 * PERIOD if self._handed == before else 0.0
            before = self._handed
        self._kill(patience)
        raise self._failure()

    def _received(self, timeout: float) -> list[list[Any]]:
        """The answers that arrive within `timeout` [s]; raises FesError once no more can arrive."""
        if not select.select([self._answers], [], [], timeout)[0]:
            return []
        piece = os.read(self._answers, _PIECE)
        answers = list(self._splitter.feed(piece))
        if not piece or any(request == frames.FAILED for request, _ in answers):
            raise self._failure(answers)
        return answers

    def _failure(self, answers: list[list[Any]] | None = None) -> FesError:
        """The error that ended the writer."""
        if self._is_over:
            return FesError(f"cannot write {self._path}: its writer has ended")
        answers = answers or []
        with contextlib.suppress(OSError):  # what it sent before its end
            while select.select([self._answers], [], [], PATIENCE)[0] and (piece := os.read(self._answers, _PIECE)):
                answers += self._splitter.feed(piece)
        texts = [str(text) for request, text in answers if request == frames.FAILED]
        code = self._end()
        how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        if self._stuck_for is not None:
            how = f"made no progress for {self._stuck_for:g} s"
        return FesError(texts[0] if texts else f"cannot write {self._path}: the process that writes it {how}")

    def _kill(self, patience: float) -> None:
        """End a writer that made no progress for `patience` [s]."""
        self._stuck_for = patience
        self._process.kill()

    def _end(self) -> int:
        """End the thread, and the writer with its pipe; returns its exit code."""
        self._is_over = True
        self._wake.put(False)
        try:
            code = self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        self._thread.join()
        os.close(self._answers)
        self._file.close()
        return code

    def _hand_over(self) -> None:
        """Write frames into the pipe until it is closed, or the writer has ended."""
        assert self._process.stdin is not None
        pipe, goes_on = self._process.stdin, True
        try:
            while goes_on:
                with contextlib.suppress(queue.Empty):
                    goes_on = self._wake.get(timeout=PERIOD)
                waiting = memoryview(b"".join([self._frames.popleft() for _ in range(len(self._frames))]))
                while waiting:
                    count = os.write(pipe.fileno(), waiting[:_PIECE])
                    self._handed += count
                    waiting = waiting[count:]
        except OSError:
            self._is_lost = True
        finally:
            pipe.close()


def _start(path: Path, fileno: int) -> tuple["subprocess.Popen[bytes]", int]:
    """A writer of an open file, and the file number at which its answers arrive; raises OSError."""
    answers, outgoing = os.pipe()
    try:
        with signals.blocked():  # until the writer ignores them
            process = subprocess.Popen(
                [sys.executable, "-P", "-c", _START, path, str(fileno), str(outgoing), *map(str, sys.path)],
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=(fileno, outgoing),
                start_new_session=True,  # a Ctrl-C reaches only the run
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )
    except BaseException:
        os.close(answers)
        raise
    finally:
        os.close(outgoing)
    return process, answers
