"""Workers on this machine: a process a core, none of which outlives the sweep."""

import contextlib
import ctypes
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext
from queue import Empty, SimpleQueue

from console.sweep import work
from console.sweep.work import Batch, Done, Watch, Workers
from fes.errors import FesError

ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""A worker has a core of its own: threads of the linear algebra would only take turns."""


PERIOD = 0.1
"""Time [s] between two looks at what the workers have done."""

Ticks = ctypes.Array[ctypes.c_int64]
"""Ticks done of each batch; each place has one writer, so no lock is needed."""

_ticks: Ticks | None = None
"""In a worker: the array of its sweep."""


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def hired(jobs: int) -> Iterator[Workers]:
    """As many workers as `jobs`; they start when there is work, and end with it."""
    yield Workers(jobs, partial(_carry_out, jobs))


def _carry_out(jobs: int, batches: Sequence[Batch], watch: Watch) -> Generator[list[Done], None, None]:
    if not batches:
        return
    context = multiprocessing.get_context("spawn")
    ticks: Ticks = context.RawArray(ctypes.c_int64, len(batches))
    with _pool(min(jobs, len(batches)), context, ticks) as pool:
        try:
            ended: SimpleQueue[Future[list[Done]]] = SimpleQueue()
            with _unheard(signal.SIGINT):
                for at, batch in enumerate(batches):
                    pool.submit(_work, at, batch).add_done_callback(ended.put)
            left, looked = len(batches), time.monotonic()
            while left:
                with contextlib.suppress(Empty):
                    yield ended.get(timeout=PERIOD).result()
                    left -= 1
                if left == 0 or time.monotonic() - looked >= PERIOD:
                    looked = time.monotonic()
                    watch(sum(ticks))
        except BrokenProcessPool:
            raise FesError("a worker of the sweep was ended from outside; the same command resumes it") from None


@contextlib.contextmanager
def _pool(count: int, context: SpawnContext, ticks: Ticks) -> Iterator[ProcessPoolExecutor]:
    """A pool on a leash: when this end of the pipe closes, with the block or with this process, the workers end."""
    held, leash = context.Pipe(duplex=False)
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    pool = ProcessPoolExecutor(count, context, _begin, (held, ticks))
    try:
        yield pool
        pool.shutdown(wait=True)
    finally:
        leash.close()
        pool.shutdown(wait=True, cancel_futures=True)
        held.close()
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin(leash: Connection, ticks: Ticks) -> None:
    """In a worker: end when the other end of the leash is closed, and count its ticks in `ticks`."""
    global _ticks
    _ticks = ticks

    def hold() -> None:
        with contextlib.suppress(EOFError, OSError):
            leash.recv_bytes()
        os._exit(0)

    threading.Thread(target=hold, name="leash", daemon=True).start()


def _work(at: int, batch: Batch) -> list[Done]:
    """In a worker: carry out a batch, whose ticks are counted in its own place."""

    def tell(done: int) -> None:
        if _ticks is not None:
            _ticks[at] = done

    done = work.carry_out(batch, tell)
    tell(sum(scenario.ticks for scenario in batch.scenarios))  # a failed run did not count all of its ticks
    return done


@contextlib.contextmanager
def _unheard(number: signal.Signals) -> Iterator[None]:
    """Processes and threads that start in this block never see the signal: the terminal sends it to all alike."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {number})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {number})
