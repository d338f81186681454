"""The end of a run, repeated until each agent has received it."""

import asyncio
import time
from collections.abc import Callable, Sequence

import numpy as np

from fes.arrays.types import Bools, Bytes

LINGER = 5.0
"""A world whose run is over stays at most this long [s] for robots that have not received the farewell."""

PROMPT = 1.0
"""An agent withdraws its tokens within this time [s] of the farewell; a token that is lost later belongs
to an agent that was cut off."""

REPEAT = 0.5
"""The farewell is repeated this often [s] while a token is alive."""


class Farewell:
    """Tells each robot that the run is over, even if its link is down at that moment.

    An agent that receives the farewell withdraws its tokens at once. A token that stays, or that was lost at another
    time, belongs to a robot that may not have received it. Its agent may reconnect soon, and would then wait for a
    world that never returns.
    """

    def __init__(self, observe: Sequence[Callable[[bytes], None]], alive: Bytes, changed: asyncio.Event) -> None:
        """`observe` holds, by robot, the function that publishes its observation.

        `alive` [n] is 1 for each robot with a token at any time; `changed` is set whenever one appears or is lost.
        """
        self._observe, self._alive, self._changed = observe, alive, changed
        self._payloads: list[bytes] = []
        self._published: dict[int, float] = {}
        """Robot -> time of its last farewell [s; monotonic]."""
        self._lost: dict[int, float] = {}
        """Robot -> time at which its token was lost for another reason than the farewell [s; monotonic]."""

    def publish(self, payloads: list[bytes]) -> None:
        """Publish the farewell of each robot; `payloads` in id order."""
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
        elif now - self._published.get(robot, -PROMPT) >= PROMPT:
            self._lost[robot] = now

    async def delivered(self, expected: Bools) -> None:
        """Wait until the `expected` robots [n] have received the farewell, for up to LINGER."""
        begun = time.monotonic()
        while (left := begun + LINGER - time.monotonic()) > 0.0:
            alive = np.flatnonzero((self._alive == 1) & expected).tolist()
            cut_off = [robot for robot, lost in self._lost.items() if expected[robot] and lost > begun - LINGER]
            if not alive and not cut_off:
                return
            self._changed.clear()
            try:
                async with asyncio.timeout(min(REPEAT, left)):
                    await self._changed.wait()
            except TimeoutError:
                for robot in alive:
                    self._put(robot)

    def _put(self, robot: int) -> None:
        self._published[robot] = time.monotonic()
        self._observe[robot](self._payloads[robot])
