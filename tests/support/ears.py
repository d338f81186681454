"""Radios of robots in a test, and what they hear."""

import asyncio
import functools
from collections.abc import Callable, Coroutine
from typing import ParamSpec

from fes.protocol.sealed import Sealed
from field.radio.settings import RadioSettings
from field.radio.socket import Radio
from tests.support.processes import PATIENCE

KEY, RUN = b"the team's key", "main"

P = ParamSpec("P")


def awaited(test: Callable[P, Coroutine[None, None, None]]) -> Callable[P, None]:
    """A test that runs in a loop of its own."""

    @functools.wraps(test)
    def run(*words: P.args, **named: P.kwargs) -> None:
        asyncio.run(test(*words, **named))

    return run


class Ear:
    """The beacons that a robot's radio hands on."""

    def __init__(self) -> None:
        self.heard: list[Sealed] = []
        self.arrived: list[int] = []

    def __call__(self, beacon: Sealed, arrived: int) -> None:
        self.heard.append(beacon)
        self.arrived.append(arrived)


async def comes(condition: Callable[[], bool]) -> None:
    """Wait until a condition holds."""
    async with asyncio.timeout(PATIENCE):
        while not condition():
            await asyncio.sleep(0.001)


async def radio(relay: str, robot: int, ear: Ear, key: bytes = KEY, run: str = RUN) -> Radio:
    radio = await Radio.opened(RadioSettings(relay=relay, key=key), run, robot, ear)
    asyncio.get_running_loop().add_reader(radio, radio.receive)
    return radio
