"""An observer on the bus: the world's reports, as they come."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator

from fes import keys
from fes.bus import Bus
from fes.errors import Absent, MessageError
from fes.report import Report, decode_report

MAX_WAITING = 64
"""Reports that may wait for a slow observer; older ones are forgotten."""


async def reports(bus: Bus, run: str, timeout: float, idle: float) -> AsyncIterator[Report | None]:
    """The reports of a run until its world leaves; None each time nothing came for `idle` [s].

    Raises Absent if no world appears within `timeout` [s].
    """
    loop = asyncio.get_running_loop()
    waiting: deque[bytes] = deque(maxlen=MAX_WAITING)
    news, here, left = asyncio.Event(), asyncio.Event(), asyncio.Event()

    def on_report(key: str, payload: bytes | None) -> None:
        if payload is not None:
            waiting.append(payload)
            loop.call_soon_threadsafe(news.set)

    def on_world(key: str, alive: bool) -> None:
        (here if alive else left).set()
        news.set()

    deadline = loop.time() + timeout
    bus.subscribe(keys.report(run), on_report)
    bus.watch(keys.world_alive(run), on_world)
    while True:
        try:
            async with asyncio.timeout(idle):
                await news.wait()
        except TimeoutError:
            if not here.is_set() and loop.time() > deadline:
                raise Absent(f"no world of run '{run}' appeared within {timeout:g} s") from None
            yield None
            continue
        news.clear()
        while waiting:
            try:
                yield decode_report(waiting.popleft())
            except MessageError:
                continue  # a view shows what it can read
        if left.is_set():
            return
