"""Workers on this machine: one process per core, none of which outlives the sweep."""

import contextlib
import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext
from queue import Empty, SimpleQueue
from types import ModuleType

from console.sweep import work
from console.sweep.work import Batch, Done, Workers
from console.terminal.counting import Watch
from fes.errors import FesError

ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Each worker has one core, on which threads of linear algebra would only compete."""

PERIOD = 0.1
"""Time between two readings of the workers' progress [s]."""

Ticks = ctypes.Array[ctypes.c_int64]
"""Completed ticks of each batch; each entry has one writer, so that it needs no lock."""

_ticks: Ticks | None = None
"""In a worker: the array of its sweep."""


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def hired(jobs: int) -> Iterator[Workers]:
    """`jobs` workers, which start with the first batch and end after the last."""
    yield Workers(jobs, partial(_carry_out, jobs))


def _carry_out(jobs: int, batches: Sequence[Batch], watch: Watch) -> Generator[list[Done], None, None]:
    if not batches:
        return
    context = multiprocessing.get_context("spawn")
    ticks: Ticks = context.RawArray(ctypes.c_int64, len(batches))
    with _pool(min(jobs, len(batches)), context, ticks) as pool:
        try:
            ended: SimpleQueue[Future[list[Done]]] = SimpleQueue()
            with _blocked(signal.SIGINT), _without_script():
                for index, batch in enumerate(batches):
                    pool.submit(_work, index, batch).add_done_callback(ended.put)
            remaining, reported = len(batches), time.monotonic()
            while remaining:
                with contextlib.suppress(Empty):
                    yield ended.get(timeout=PERIOD).result()
                    remaining -= 1
                if remaining == 0 or time.monotonic() - reported >= PERIOD:
                    reported = time.monotonic()
                    watch(sum(ticks))
        except BrokenProcessPool:
            raise FesError("a worker of the sweep was killed; the same command resumes the sweep") from None


@contextlib.contextmanager
def _pool(count: int, context: SpawnContext, ticks: Ticks) -> Iterator[ProcessPoolExecutor]:
    """A pool whose workers end when this end of a pipe closes: with the block, or with this process."""
    worker_end, own_end = context.Pipe(duplex=False)
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    pool = ProcessPoolExecutor(count, context, _begin, (worker_end, ticks))
    try:
        yield pool
        pool.shutdown(wait=True)
    finally:
        own_end.close()
        pool.shutdown(wait=True, cancel_futures=True)
        worker_end.close()
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin(leash: Connection, ticks: Ticks) -> None:
    """In a worker: end when the other end of `leash` closes, and count ticks in `ticks`."""
    global _ticks
    _ticks = ticks

    def end_with_leash() -> None:
        with contextlib.suppress(EOFError, OSError):
            leash.recv_bytes()
        os._exit(0)

    threading.Thread(target=end_with_leash, name="leash", daemon=True).start()


def _work(index: int, batch: Batch) -> list[Done]:
    """In a worker: carry out a batch, and count its ticks in its own entry."""

    def count(done: int) -> None:
        if _ticks is not None:
            _ticks[index] = done

    done = work.carry_out(batch, count)
    count(sum(scenario.ticks for scenario in batch.scenarios))  # a failed run leaves ticks uncounted
    return done


@contextlib.contextmanager
def _without_script() -> Iterator[None]:
    """Processes that start in this block do not import the program of this one.

    A spawned process imports the file of `__main__`. A person's script, which calls `fes.sweep`, would run in every
    worker again.
    """
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


@contextlib.contextmanager
def _blocked(number: signal.Signals) -> Iterator[None]:
    """Block a signal in the processes and threads that start here: the terminal sends it to all of them."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {number})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {number})
