"""Real Zenoh sessions with pretended gates and agents of real robots."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

from fes.transport.bus import Bus
from tests.support.fake_robots import FakeGate, report_until_cancelled
from tests.support.processes import PATIENCE
from tests.support.session import RUN, router


def run(main: Callable[[], Awaitable[None]]) -> None:
    """Run a test for a bounded time."""

    async def bounded() -> None:
        async with asyncio.timeout(PATIENCE):
            await main()

    asyncio.run(bounded())


async def until(holds: Callable[[], bool]) -> None:
    """Wait until a condition holds."""
    while not holds():
        await asyncio.sleep(0.005)


@contextlib.asynccontextmanager
async def gated(robots: Sequence[int]) -> AsyncIterator[tuple[Bus, str, dict[int, FakeGate]]]:
    """Gates of these robots on a router: their bus, the endpoint for operators, and the gates."""
    async with router() as (opened, endpoint):
        yield opened, endpoint, {robot: FakeGate(opened, RUN, robot) for robot in robots}


@contextlib.asynccontextmanager
async def reporting(bus: Bus, links: dict[int, list[int]], hold: float = 0.0, boot: int = 7) -> AsyncIterator[None]:
    """Reports of robots with these links, at 10 Hz."""
    tasks = [
        asyncio.create_task(report_until_cancelled(bus, RUN, robot, peers, hold, boot))
        for robot, peers in links.items()
    ]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
