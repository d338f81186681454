"""An observer on the bus: the world's reports, as they come."""

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
"""Reports that may wait for a slow observer; older ones are forgotten."""

RETURN = 15.0
"""A world that is not seen for this long [s], or for as long as one was waited for, has left; before, only the
connection may have been lost, or another world goes on with the run."""


STRANGE = 10
"""After so many reports of another protocol version, in STRANGE_FOR at least, and none that can be read, there is
nothing to be seen. Worlds report ten times a second, so whoever puts others between them hides none."""

STRANGE_FOR = 3.0
"""[s]"""


async def reports(bus: Bus, run: str, timeout: float, idle: float) -> AsyncIterator[Report | None]:
    """The reports of a run until it is over; None each time nothing came for `idle` [s].

    An observer that was suspended loses its session, and finds the world again when it goes on. Raises Absent if
    no world appears within `timeout` [s], or if it leaves before the run is over: it is waited for as long again, but
    for RETURN at least, not counting the time that the reader takes with what it got. Raises MessageError if the
    world speaks only another version of the protocol.
    """
    loop = asyncio.get_running_loop()
    waiting: deque[bytes] = deque(maxlen=MAX_WAITING)
    news = asyncio.Event()
    here, since, latest = False, loop.time(), None
    strange, first = 0, math.inf

    def on_report(key: str, payload: bytes | None) -> None:
        if payload is not None:
            waiting.append(payload)
            if not news.is_set():  # the reader clears it before it looks: nothing is missed, a flood is one wake-up
                loop.call_soon_threadsafe(news.set)

    def on_world(key: str, alive: bool) -> None:
        nonlocal here, since
        here, since = alive, loop.time()
        news.set()

    bus.declare_subscriber(keys.report(run), on_report)
    bus.declare_liveliness_subscriber(keys.world_alive(run), on_world)
    while True:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(idle):
                await news.wait()
        quiet = not news.is_set()
        news.clear()
        while waiting:
            try:
                latest = decode_report(waiting.popleft())
            except MessageError as error:
                if world_info.speaks_otherwise(error):
                    strange, first = strange + 1, min(first, loop.time())
                if latest is None and strange >= STRANGE and loop.time() - first >= STRANGE_FOR:
                    raise
                continue  # a view shows what it can read
            asked = loop.time()
            yield latest
            now = loop.time()
            since = min(now, since + now - asked)  # the reader may itself bring the world back
        if not here and latest is not None and latest.tick + 1 >= latest.ticks:
            return
        if not here and loop.time() - since > (max(RETURN, timeout) if latest is not None else timeout):
            what = f"left after tick {latest.tick}" if latest is not None else f"did not appear within {timeout:g} s"
            raise Unavailable(f"the world of run '{run}' {what}")
        if quiet:
            yield None
