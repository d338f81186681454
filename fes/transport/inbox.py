"""The way from Zenoh's threads to the loop: one wake-up when enough messages have arrived.

A full inbox drops and counts further messages, good or bad. None is lost permanently: the world resends a tick to
robots whose command is missing, and an agent that has answered a tick answers it again.
"""

import asyncio
from collections import deque

from fes.errors import FesError

Item = tuple[str, bytes | None]

LIMIT = 100_000
"""Largest number of messages that wait; further ones are dropped and counted."""

LIMIT_BYTES = 1 << 26
"""Largest size of the messages that wait [bytes]."""


class Inbox:
    """Messages that wait for the loop. `put` may be called from any thread, all else on the loop."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._items: deque[Item] = deque()
        self._wanted = 0
        self._waiter: asyncio.Future[None] | None = None
        self._failure: FesError | None = None
        self._bytes = 0
        self._nudged = False
        self.dropped = 0

    def put(self, key: str, payload: bytes | None) -> None:
        """Hand over one message."""
        size = len(payload) if payload is not None else 0
        if len(self._items) >= LIMIT or self._bytes + size > LIMIT_BYTES:
            self.dropped += 1
            return
        self._bytes += size
        self._items.append((key, payload))
        if 0 < self._wanted <= len(self._items):
            self._wanted = 0
            self._loop.call_soon_threadsafe(self._wake)

    def nudge(self) -> None:
        """End the present wait early, or the next one."""
        self._nudged = True
        self._wake()

    def fail(self, failure: FesError) -> None:
        """End every present and future wait with `failure`."""
        self._failure = self._failure or failure
        self._wake()

    async def wait(self, count: int, timeout: float) -> bool:
        """Wait until `count` messages have arrived; False if `timeout` [s] passed first, or after a nudge.

        After a failure: True while a message is left to be read; then raises the failure.
        """
        end = self._loop.time() + timeout
        timer = self._loop.call_later(timeout, self._wake)
        try:
            # A wake-up may belong to an earlier wait that has ended: check the condition each time.
            while len(self._items) < count and not self._over() and self._loop.time() < end:
                self._waiter = self._loop.create_future()
                self._wanted = count
                if len(self._items) >= count:
                    break
                await self._waiter
        finally:
            timer.cancel()
            self._wanted, self._nudged = 0, False
        # Messages before a failure are read first: a world announces that the run is over, then leaves.
        if len(self._items) >= count or (self._items and self._failure is not None):
            return True
        if self._failure is not None:
            raise self._failure
        return False

    def _over(self) -> bool:
        return self._nudged or self._failure is not None

    def drain(self) -> list[Item]:
        """All waiting messages, in order of arrival."""
        items = self._items
        taken = [items.popleft() for _ in range(len(items))]
        self._bytes = 0  # only a bound: a message that is put meanwhile may not be counted
        return taken

    def _wake(self) -> None:
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)
