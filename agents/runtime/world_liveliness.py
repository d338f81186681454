"""Liveliness of the world: an agent waits for the world at the start, and again whenever its token is lost."""

import asyncio
import logging

from fes.errors import Unavailable
from fes.transport.inbox import ThreadInbox

GRACE = 5.0
"""Time [s] after the world's return in which other processes may still not see it."""

RETRY = 0.2
"""Pause [s] before a recall is repeated."""


class WorldLiveliness:
    """The world's liveliness token. While the world is absent, the robots of an agent stand still."""

    def __init__(self, name: str, inbox: ThreadInbox) -> None:
        self.is_new = False
        """True if the world has returned, but has not resumed the run yet."""
        self.was_seen = False
        """True once the world's token has been alive."""
        self._name, self._inbox = name, inbox
        self._alive = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self.patience = 0.0
        """Longest absence of the world after which the agent still continues [s]."""
        self._returned_at = -GRACE
        self._timer: asyncio.TimerHandle | None = None
        self._logger = logging.getLogger("agent")

    async def wait(self, timeout: float) -> None:
        """Wait for the world; raises Unavailable after `timeout` [s]. Its message gives the whole `patience`."""
        try:
            async with asyncio.timeout(timeout):
                await self._alive.wait()
        except TimeoutError:
            raise Unavailable(f"no {self._name.removeprefix('the ')} appeared within {self.patience:g} s") from None

    def on_token(self, alive: bool, tick: int) -> None:
        """Handle the appearance or the loss of the world's token, after `tick` was answered."""
        if alive and self._timer is not None:
            self._timer.cancel()
            self._timer, self.is_new = None, True
            self._returned_at = self._loop.time()
            self._logger.info("%s is back", self._name)
        if alive:
            self.was_seen = True
            self._alive.set()
        elif self._alive.is_set():
            self._alive.clear()
            self._logger.info("%s left after tick %d: waiting %g s for it", self._name, tick, self.patience)
            gone = Unavailable(f"{self._name} left after tick {tick}")
            self._timer = self._loop.call_later(self.patience, self._inbox.fail, gone)

    @property
    def is_alive(self) -> bool:
        """True while the world's token is alive."""
        return self._alive.is_set()

    async def should_retry(self) -> bool:
        """True if a recall that timed out is worth repeating: the world is alive, or returns in time.

        Returns after a pause, or after the world's absence.
        """
        if not self._alive.is_set():
            return await self.should_retry_rejected()
        await asyncio.sleep(RETRY)
        return True

    async def should_retry_rejected(self) -> bool:
        """True if a rejected recall is worth repeating: the world has just returned, or returns in time.

        Until its agents see it again, a restarted world may lack beacons that they will resend.
        """
        if not self._alive.is_set():
            try:
                async with asyncio.timeout(self.patience):
                    await self._alive.wait()
            except TimeoutError:
                return False
        if self._loop.time() - self._returned_at > GRACE:
            return False
        await asyncio.sleep(RETRY)
        return True
