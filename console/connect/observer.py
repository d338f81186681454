"""An observer on the bus: the reports of a world, in order of arrival."""

import asyncio
import contextlib
import math
from collections import deque
from collections.abc import AsyncIterator

from fes.errors import MessageError, Unavailable
from fes.protocol import keys, world_info
from fes.protocol.report import Report, decode_report
from fes.transport.bus import Bus

MAX_WAITING = 64
"""Largest number of reports that wait for a slow observer; the oldest are dropped."""

RETURN = 15.0
"""Shortest absence [s] after which a world counts as gone: the connection may return, or another world may resume
the run."""

FOREIGN_REPORTS = 10
"""Number of reports of another protocol version after which an observer that has decoded none raises an error.

Worlds report ten times per second, so reports that another program mixes in do not hide those of the world."""

FOREIGN_PERIOD = 3.0
"""Shortest time over which these reports must arrive [s]."""


async def reports(bus: Bus, run: str, timeout: float, idle: float) -> AsyncIterator[Report | None]:
    """The reports of a run until it is over; None each time `idle` [s] pass without a report.

    A suspended observer loses its session, and finds the world again when it continues. Raises Unavailable if no
    world appears within `timeout` [s], or if the world leaves before the run is over and stays away for `timeout`,
    at least for RETURN. Time that the caller spends between two reports does not count. Raises MessageError if the
    world sends only another version of the protocol.
    """
    loop = asyncio.get_running_loop()
    waiting: deque[bytes] = deque(maxlen=MAX_WAITING)
    wake_up = asyncio.Event()
    is_alive, since, latest = False, loop.time(), None
    foreign, first = 0, math.inf

    def on_report(key: str, payload: bytes | None) -> None:
        if payload is not None:
            waiting.append(payload)
            # The event is cleared before the queue is read: no report is missed, and a flood is one wake-up.
            if not wake_up.is_set():
                loop.call_soon_threadsafe(wake_up.set)

    def on_world(key: str, alive: bool) -> None:
        nonlocal is_alive, since
        is_alive, since = alive, loop.time()
        wake_up.set()

    with contextlib.ExitStack() as declared:
        declared.callback(bus.declare_subscriber(keys.report(run), on_report))
        declared.callback(bus.declare_liveliness_subscriber(keys.world_alive(run), on_world))
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(idle):
                    await wake_up.wait()
            is_idle = not wake_up.is_set()
            wake_up.clear()
            while waiting:
                try:
                    latest = decode_report(waiting.popleft())
                except MessageError as error:
                    if world_info.speaks_otherwise(error):
                        foreign, first = foreign + 1, min(first, loop.time())
                    if latest is None and foreign >= FOREIGN_REPORTS and loop.time() - first >= FOREIGN_PERIOD:
                        raise
                    continue  # a view shows the reports that it can decode
                before = loop.time()
                yield latest
                now = loop.time()
                since = min(now, since + now - before)  # the caller may itself restart the world
            if not is_alive and latest is not None and latest.tick + 1 >= latest.ticks:
                return
            if not is_alive and loop.time() - since > (max(RETURN, timeout) if latest is not None else timeout):
                event = (
                    f"left after tick {latest.tick}" if latest is not None else f"did not appear within {timeout:g} s"
                )
                raise Unavailable(f"the world of run '{run}' {event}")
            if is_idle:
                yield None
