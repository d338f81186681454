"""Workers on this machine: a process a core, none of which outlives the sweep."""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing.connection import Connection

from console.sweep import work
from console.sweep.work import Batch, Done, Workers
from fes.errors import FesError

ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""A worker has a core of its own: threads of the linear algebra would only take turns."""


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def hired(jobs: int) -> Iterator[Workers]:
    """As many workers as `jobs`; they start when there is work, and end with it."""
    yield Workers(jobs, partial(_carry_out, jobs))


def _carry_out(jobs: int, batches: Sequence[Batch]) -> Generator[list[Done], None, None]:
    if not batches:
        return
    with _pool(min(jobs, len(batches))) as pool:
        try:
            with _unheard(signal.SIGINT):
                futures = [pool.submit(work.carry_out, batch) for batch in batches]
            for future in as_completed(futures):
                yield future.result()
        except BrokenProcessPool:
            raise FesError("a worker of the sweep was ended from outside; the same command resumes it") from None


@contextlib.contextmanager
def _pool(count: int) -> Iterator[ProcessPoolExecutor]:
    """A pool on a leash: when this end of the pipe closes, with the block or with this process, the workers end."""
    context = multiprocessing.get_context("spawn")
    held, leash = context.Pipe(duplex=False)
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    pool = ProcessPoolExecutor(count, context, _hold, (held,))
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


def _hold(leash: Connection) -> None:
    """In a worker: end when the other end of the leash is let go."""

    def wait() -> None:
        with contextlib.suppress(EOFError, OSError):
            leash.recv_bytes()
        os._exit(0)

    threading.Thread(target=wait, name="leash", daemon=True).start()


@contextlib.contextmanager
def _unheard(number: signal.Signals) -> Iterator[None]:
    """Processes and threads that start in this block never see the signal: the terminal sends it to all alike."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {number})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {number})
