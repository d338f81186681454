"""A long call in a thread of its own, which its caller can interrupt.

The caller's thread only waits. Python raises an interrupt there, between any two instructions, so it leaves no file
and no array half written: the work ends at its next tick. Nor does the work share an event loop with a notebook.
"""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import Future
from typing import TypeVar

from console.api.display import Show
from fes.errors import Stopped

PERIOD = 0.1
"""Time between two calls of a Show, and longest time to notice an interrupt that another thread receives [s]."""

THREAD = "fes"
"""Name of the thread."""

INTERRUPTED = "interrupted"
"""Reason of a Stopped."""

T = TypeVar("T")


class Work:
    """The progress of a call, and the request to stop it."""

    def __init__(self, total: int = 0) -> None:
        self.done = 0
        """Completed ticks."""
        self.total = total
        """Ticks of the whole call; 0 if unknown."""
        self._stopped = threading.Event()
        self._cancel: Callable[[], None] | None = None
        """Cancels the event loop of the work, while there is one."""
        self._lock = threading.Lock()

    def reach(self, done: int) -> None:
        """Note the completed ticks; raises Stopped after `stop`."""
        self.done = done
        self.check()

    def check(self) -> None:
        """Raise Stopped after `stop`."""
        if self._stopped.is_set():
            raise Stopped(INTERRUPTED)

    def pause(self, seconds: float) -> None:
        """Wait for this time [s], or raise Stopped after `stop`."""
        self._stopped.wait(max(0.0, seconds))
        self.check()

    def stop(self) -> None:
        """Let the work end with Stopped."""
        with self._lock:
            self._stopped.set()
            if self._cancel is not None:
                self._cancel()

    def supervise(self, main: Callable[[], Coroutine[None, None, T]]) -> T:
        """The result of `main`, run to its end in an event loop of this thread; `stop` cancels it.

        It then cleans up, and this call raises Stopped.
        """
        return asyncio.run(self._until_stopped(main))

    async def _until_stopped(self, main: Callable[[], Coroutine[None, None, T]]) -> T:
        loop, task = asyncio.get_running_loop(), asyncio.ensure_future(main())

        def cancel() -> None:
            loop.call_soon_threadsafe(task.cancel)

        with self._lock:
            self._cancel = cancel
            if self._stopped.is_set():
                task.cancel()
        try:
            return await task
        except asyncio.CancelledError:
            raise Stopped(INTERRUPTED) from None
        finally:
            with self._lock:
                self._cancel = None


def call(work: Work, function: Callable[[], T], show: Show | None) -> T:
    """The result of `function`, which runs in a thread of its own, and calls `work.reach` after each tick.

    `show` is called periodically in this thread, and once at the end. An interrupt, or an error of `show`, stops the
    work and is raised once the thread has ended. A second interrupt is raised at once.
    """
    outcome: Future[T] = Future()
    # An interrupt in a wait for the Future may leave the lock of its event held, and the thread would never end. This
    # lock is only released by the thread, which never waits for it.
    running = threading.Lock()
    running.acquire()
    thread = threading.Thread(target=_fulfil, args=(outcome, function, running), name=THREAD)
    try:
        thread.start()
        while not running.acquire(timeout=PERIOD):
            if show is not None:
                show(work.done, work.total)
        thread.join()
        if show is not None and outcome.exception() is None:
            show(work.done, work.total)
    except BaseException as interrupt:
        work.stop()
        if thread.ident is not None:
            try:
                thread.join()
            except RuntimeError:  # the interrupt came within start: the thread may run, and ends at its next tick
                running.acquire(timeout=PERIOD)
        error = outcome.exception() if outcome.done() else None
        if isinstance(error, Stopped):
            interrupt.add_note(str(error))
        raise
    return outcome.result()


def _fulfil(outcome: "Future[T]", function: Callable[[], T], running: threading.Lock) -> None:
    try:
        outcome.set_result(function())
    except BaseException as error:
        outcome.set_exception(error)
    finally:
        running.release()
