"""Workers of a Dask cluster, which carry out the same batches on many machines.

Dask comes with the extra `cluster`, and is imported only for a sweep with --scheduler.
"""

import contextlib
import hashlib
import logging
import math
import re
import time
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from functools import partial
from typing import TYPE_CHECKING

from console.sweep import work
from console.sweep.work import Batch, Done, Workers
from console.terminal.counting import Watch, ignore
from fes.errors import FesError
from fes.protocol.world_info import version
from fes.system import fingerprint
from fes.system.distribution import install
from fes.transport import addresses

if TYPE_CHECKING:
    from distributed import Client

PATIENCE = 10.0
"""Time limit for the scheduler's answer, and for its first worker [s]."""

PERIOD = 0.1
"""Time between two looks at the batches [s]."""

REPORTING = 0.5
"""Time between two reports of a worker [s]."""

TOPIC = "fes-sweep"
"""Topic of these reports. The scheduler keeps a bounded number of events per topic, so all sweeps have one."""


@contextlib.contextmanager
def connected(address: str) -> Iterator[Workers]:
    """The workers of the scheduler at `address`; raises FesError if there is none."""
    match = re.fullmatch(r"(?:tcp|tls|ucx|ws|wss)://([^\s/]+:\d{1,5})", address)
    if match is None:
        raise FesError(f"--scheduler expects an address such as tcp://10.0.0.1:8786, got '{address}'")
    endpoint = f"tcp/{match[1]}"
    addresses.check(endpoint, listening=False)
    if cause := addresses.unresolved(endpoint):
        raise FesError(f"no Dask scheduler answers at {address}: {cause}")
    try:
        import distributed
    except ImportError:
        raise FesError(f"--scheduler needs dask.distributed: {install('cluster')}") from None
    for name in ("distributed", "distributed.client"):  # errors are raised here, in one line
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except OSError as error:
        raise FesError(f"no Dask scheduler answers at {address}: {_line(error)}") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise FesError(f"the Dask scheduler at {address} has no workers") from None
        yield Workers(sum(client.nthreads().values()), partial(_carry_out, client))


def _carry_out(client: "Client", batches: Sequence[Batch], watch: Watch) -> Generator[list[Done], None, None]:
    """Results of batches; each worker reports the ticks of its batch as events of the scheduler."""
    from distributed import as_completed

    ticks = {_key(batch): 0 for batch in batches}

    def count(event: tuple[float, tuple[str, int]]) -> None:  # in the client's own thread: it only stores
        key, done = event[1]
        if key in ticks:
            ticks[key] = max(ticks[key], done)

    client.subscribe_topic(TOPIC, count)
    versions = (version(), fingerprint.text())
    futures = [
        client.submit(_at_worker, versions, batch, key=_key(batch), retries=0, pure=False) for batch in batches
    ]
    sizes = {_key(batch): sum(scenario.ticks for scenario in batch.scenarios) for batch in batches}
    try:
        completed = as_completed(futures, loop=client.loop)
        while not completed.is_empty():
            for future in completed.next_batch(block=False):
                yield future.result()
                ticks[future.key] = sizes[future.key]
            watch(sum(ticks.values()))
            time.sleep(PERIOD)
    except FesError:
        raise
    except (Exception, CancelledError) as error:
        raise FesError(f"the Dask cluster failed: {_line(error)}; the same command resumes the sweep") from None
    finally:
        with contextlib.suppress(Exception, CancelledError):
            client.cancel(futures)


def _at_worker(versions: tuple[str, str], batch: Batch) -> list[Done]:
    """On a worker: carry out a batch if version and arithmetic equal those of the sweep."""
    package, arithmetic = versions
    if version() != package:
        raise FesError(f"a Dask worker has fes {version()}, and the sweep is of fes {package}")
    if fingerprint.text() != arithmetic:
        raise FesError(f"a Dask worker has {fingerprint.text()}, and the sweep is of {arithmetic}")
    return work.carry_out(batch, _reported(_key(batch)))


def _reported(key: str) -> Watch:
    """On a worker: report the completed ticks of a batch to the scheduler, every REPORTING [s]."""
    from distributed import get_worker

    try:
        worker, reported = get_worker(), -math.inf
    except ValueError:  # a scheduler of threads has no worker
        return ignore

    def report(done: int) -> None:
        nonlocal reported
        now = time.monotonic()
        if now - reported >= REPORTING:
            reported = now
            worker.log_event(TOPIC, (key, done))

    return report


def _key(batch: Batch) -> str:
    return f"fes-sweep-{hashlib.sha256(''.join(batch.keys).encode()).hexdigest()}"


def _line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
