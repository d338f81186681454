"""The end of a run, repeated until it is heard."""

import asyncio
import time
from collections.abc import Callable, Sequence

import numpy as np

from fes.arrays.types import Bools
from world.server.registry import AgentRegistry

LINGER = 5.0
"""A world whose run is over stays at most this long [s] for robots that have not heard of it."""

PROMPT = 1.0
"""An agent that hears of the end withdraws its tokens within this time [s]; a token that goes later was cut off."""

REPEAT = 0.5
"""The farewell is repeated this often [s] while a token stands."""


class Farewell:
    """Tells every robot that the run is over, also one whose link is down at that moment.

    An agent that hears it withdraws its tokens at once. A token that stands, or that went at another time, belongs to
    a robot that may not know: its agent would wait for a world that never returns, and may reconnect in a moment.
    """

    def __init__(self, observe: Sequence[Callable[[bytes], None]], registry: AgentRegistry) -> None:
        """`observe` puts a robot's observation, by id."""
        self._observe, self._roster = observe, registry
        self._payloads: list[bytes] = []
        self._said: dict[int, float] = {}
        self._lost: dict[int, float] = {}
        """Robot -> time at which its token went for another reason than the farewell [s; monotonic]."""

    def say(self, payloads: list[bytes]) -> None:
        """Put the farewell of each robot, in id order."""
        self._payloads = payloads
        for robot in range(len(payloads)):
            self._put(robot)

    def on_token(self, robot: int, alive: bool) -> None:
        """Handle the appearance or the loss of a robot's token."""
        now = time.monotonic()
        if alive:
            self._lost.pop(robot, None)
            if self._payloads:
                self._put(robot)
        elif now - self._said.get(robot, -PROMPT) >= PROMPT:
            self._lost[robot] = now

    async def heard(self, expected: Bools) -> None:
        """Wait until the `expected` robots [n] have heard it, for up to LINGER."""
        begun = time.monotonic()
        while (left := begun + LINGER - time.monotonic()) > 0.0:
            standing = np.flatnonzero((self._roster.alive == 1) & expected).tolist()
            cut = [robot for robot, went in self._lost.items() if expected[robot] and went > begun - LINGER]
            if not standing and not cut:
                return
            self._roster.changed.clear()
            try:
                async with asyncio.timeout(min(REPEAT, left)):
                    await self._roster.changed.wait()
            except TimeoutError:
                for robot in standing:
                    self._put(robot)

    def _put(self, robot: int) -> None:
        self._said[robot] = time.monotonic()
        self._observe[robot](self._payloads[robot])
