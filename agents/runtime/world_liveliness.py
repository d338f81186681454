"""Whether the world is there: an agent waits for it at first, and again when it has left."""

import asyncio
import logging

from fes.errors import Unavailable
from fes.transport.inbox import Inbox

GRACE = 5.0
"""Others may take this long [s] to find a world again that is back."""

RETRY = 0.2
"""[s]"""


class WorldLiveliness:
    """The world, as its liveliness token tells of it. While it is away the robots of an agent stand still."""

    def __init__(self, name: str, inbox: Inbox) -> None:
        self.is_new = False
        """Whether it has come back, and not gone on yet."""
        self.was_seen = False
        """Whether it ever was there."""
        self._name, self._inbox = name, inbox
        self._here = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self.patience = 0.0
        """How long it may be away [s]."""
        self._came = -GRACE
        self._giving_up: asyncio.TimerHandle | None = None
        self._logger = logging.getLogger("agent")

    async def appears(self, timeout: float) -> None:
        """Wait for it; raises Absent after `timeout` [s], which belong to a patience that may be longer."""
        try:
            async with asyncio.timeout(timeout):
                await self._here.wait()
        except TimeoutError:
            raise Unavailable(f"no {self._name.removeprefix('the ')} appeared within {self.patience:g} s") from None

    def on_token(self, alive: bool, tick: int) -> None:
        """Its token came or went, after `tick` was answered."""
        if alive and self._giving_up is not None:
            self._giving_up.cancel()
            self._giving_up, self.is_new = None, True
            self._came = self._loop.time()
            self._logger.info("%s is back", self._name)
        if alive:
            self.was_seen = True
            self._here.set()
        elif self._here.is_set():
            self._here.clear()
            self._logger.info("%s left after tick %d: waiting %g s for it", self._name, tick, self.patience)
            gone = Unavailable(f"{self._name} left after tick {tick}")
            self._giving_up = self._loop.call_later(self.patience, self._inbox.fail, gone)

    @property
    def is_here(self) -> bool:
        """True while its token stands."""
        return self._here.is_set()

    async def stays(self) -> bool:
        """True if it may answer another time: it is there, or comes back in time; after a moment."""
        if not self._here.is_set():
            return await self.comes_back()
        await asyncio.sleep(RETRY)
        return True

    async def comes_back(self) -> bool:
        """Whether there is hope that what was lost can be had: it was away, and now is back."""
        if not self._here.is_set():
            try:
                async with asyncio.timeout(self.patience):
                    await self._here.wait()
            except TimeoutError:
                return False
        if self._loop.time() - self._came > GRACE:
            return False
        await asyncio.sleep(RETRY)
        return True
