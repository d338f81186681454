"""The way from Zenoh's threads to the consumer of messages: one wake-up when enough messages have arrived.

The consumer is a coroutine on the loop (`Inbox`), or a thread of its own (`ThreadInbox`). A thread wakes at a lower
cost: it needs no pass of the loop, no socket and no future.

A full inbox drops and counts further messages, good or bad. None is lost permanently: the world resends a tick to
robots whose command is missing, and an agent that has answered a tick answers it again.
"""

import asyncio
import queue
import time
from abc import ABC, abstractmethod
from collections import deque

from fes.errors import FesError

Item = tuple[str, bytes | None]

LIMIT = 100_000
"""Largest number of messages that wait; further ones are dropped and counted."""

LIMIT_BYTES = 1 << 26
"""Largest size of the messages that wait [bytes]."""


class Messages(ABC):
    """Messages that wait for their consumer. `put` may be called from any thread."""

    def __init__(self) -> None:
        self._items: deque[Item] = deque()
        self._wanted = 0
        """Number of messages that the consumer waits for; 0 while it does not wait."""
        self._failure: FesError | None = None
        self._bytes = 0
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
            self._wake_from_thread()

    def drain(self) -> list[Item]:
        """All waiting messages, in order of arrival."""
        items = self._items
        taken = [items.popleft() for _ in range(len(items))]
        self._bytes = 0  # only a bound: a message that is put meanwhile may not be counted
        return taken

    def _has_arrived(self, count: int) -> bool:
        """True if `count` messages wait, or after a failure any message; raises the failure if none does.

        Messages before a failure are read first: a world announces that the run is over, then leaves.
        """
        if len(self._items) >= count or (self._items and self._failure is not None):
            return True
        if self._failure is not None:
            raise self._failure
        return False

    @abstractmethod
    def _wake_from_thread(self) -> None:
        """Wake the consumer; called in any thread. A second call for the same wait has no effect."""


class Inbox(Messages):
    """Messages that wait for the loop. All methods but `put` are called on the loop."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__()
        self._loop = loop
        self._waiter: asyncio.Future[None] | None = None
        self._nudged = False

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

        The loop runs at least once meanwhile. After a failure: True while a message is left to be read; then raises
        the failure.
        """
        if len(self._items) >= count:
            await asyncio.sleep(0.0)
            self._nudged = False
            return True
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
        return self._has_arrived(count)

    def _over(self) -> bool:
        return self._nudged or self._failure is not None

    def _wake_from_thread(self) -> None:
        self._loop.call_soon_threadsafe(self._wake)

    def _wake(self) -> None:
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)


class ThreadInbox(Messages):
    """Messages that wait for one thread. `wait` and `drain` are called in it; all else in any thread."""

    def __init__(self) -> None:
        super().__init__()
        self._bell: queue.SimpleQueue[None] = queue.SimpleQueue()
        self._closed = False

    def fail(self, failure: FesError) -> None:
        """End every present and future wait with `failure`, once all messages have been read."""
        self._failure = self._failure or failure
        self._wake_from_thread()

    def close(self, failure: FesError) -> None:
        """End every present and future wait with `failure`, at once."""
        self._closed = True
        self.fail(failure)

    def wait(self, count: int, timeout: float) -> bool:
        """Block until `count` messages have arrived; False if `timeout` [s] passed first.

        After a failure: True while a message is left to be read; then raises the failure.
        """
        if len(self._items) < count and self._failure is None:
            self._block(count, time.monotonic() + timeout)
        if self._closed and self._failure is not None:
            raise self._failure
        return self._has_arrived(count)

    def _block(self, count: int, end: float) -> None:
        # A ring may belong to an earlier wait that has ended: check the condition each time.
        while (left := end - time.monotonic()) > 0.0:
            self._wanted = count
            if len(self._items) >= count or self._failure is not None:
                break
            try:
                self._bell.get(timeout=left)
            except queue.Empty:
                break
            if len(self._items) >= count or self._failure is not None:
                break
        self._wanted = 0

    def _wake_from_thread(self) -> None:
        self._bell.put(None)
