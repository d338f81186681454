"""When an agent takes its next step: at each tick in lockstep, at the newest one when the clock is live."""

import time
from collections.abc import AsyncIterator, Callable

from agents.runtime.outbox import Outbox
from agents.runtime.world_liveliness import WorldLiveliness
from fes.errors import MessageError, Unavailable
from fes.protocol import keys, messages
from fes.protocol.messages import Observation
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox

SILENCE_TIMEOUT = 3600.0
"""An agent that hears nothing from a living world for this long [s] gives up."""

QUIET = 5.0
"""After each silence of this length [s] an agent asks the world whether it is still welcome."""


class TickSource:
    """The observations of each tick that is to be answered, one per robot in id order."""

    def __init__(
        self,
        robots: tuple[int, ...],
        inbox: Inbox,
        outbox: Outbox,
        drops: DropLog,
        on_quiet: Callable[[], None] = lambda: None,
    ) -> None:
        """`on_quiet` is called after each time QUIET without a message."""
        self._robots, self._on_quiet = robots, on_quiet
        self._inbox, self._outbox = inbox, outbox
        self._drops = drops
        self.tick = -1
        """The last one."""
        self._forgotten = -1
        self.skipped = 0
        """Ticks that nobody answered, as a newer one was there already."""

    async def lockstep(self, world: WorldLiveliness) -> AsyncIterator[list[Observation]]:
        """Every tick. Those that come again are answered again."""
        waiting: dict[int, Observation] = {}
        while True:
            async for key, observation in self._received(len(self._robots) - len(waiting)):
                if observation.over:
                    return
                if observation.tick > self.tick + 1 and observation.since == observation.tick:
                    self.tick = observation.tick - 1  # the run went on without it
                    waiting.clear()
                if observation.tick == self.tick + 1:
                    waiting.setdefault(observation.robot, observation)
                elif observation.tick == self.tick or (world.is_new and observation.tick < self.tick):
                    # A world that comes back has gone through what it knew again, a tick less than this at most.
                    if self._outbox.has(observation.tick):
                        self._outbox.resend(observation.tick, observation.robot)
                    elif observation.tick < self.tick:
                        self._behind(key, observation.tick)
                elif self.tick >= 0:  # else it stands by, and its time has not come yet
                    self._drops.reject("Observation: is not for this tick", f"{key}: tick {observation.tick}")
            if len(waiting) == len(self._robots):
                self.tick += 1
                world.is_new = False
                yield [waiting[robot] for robot in self._robots]
                waiting.clear()

    async def live(self, world: WorldLiveliness) -> AsyncIterator[list[Observation]]:
        """The newest tick of which every robot's observation is here."""
        newest: dict[int, dict[int, Observation]] = {}
        while True:
            async for _, observation in self._received(1):
                if observation.over:
                    return
                if world.is_new and observation.tick <= self.tick:
                    self.tick = observation.tick - 1  # it is back where it was a moment before
                world.is_new = False
                if observation.tick > self.tick:
                    newest.setdefault(observation.tick, {})[observation.robot] = observation
            whole = [tick for tick, found in newest.items() if len(found) == len(self._robots)]
            if whole:
                tick, before = max(whole), self.tick
                observations = [newest[tick][robot] for robot in self._robots]
                newest = {at: found for at, found in newest.items() if at > tick}
                if before >= 0 and observations[0].since <= before:
                    self.skipped += tick - before - 1
                self.tick = tick
                yield observations

    def _behind(self, key: str, tick: int) -> None:
        """A world that is back asks for a tick that is forgotten: if it does so again, it cannot go on with us."""
        if tick == self._forgotten:
            raise Unavailable(f"the world is back at tick {tick}, and {self.tick} was answered")
        self._forgotten = tick
        self._drops.reject("Observation: is not for this tick", f"{key}: tick {tick}")

    async def _received(self, count: int) -> AsyncIterator[tuple[str, Observation]]:
        """Wait for that many messages; the key and content of all that are here and can be read."""
        end = time.monotonic() + SILENCE_TIMEOUT
        while not await self._inbox.wait(count, QUIET):
            if time.monotonic() >= end:
                raise Unavailable(f"the world said nothing for {SILENCE_TIMEOUT:g} s after tick {self.tick}")
            self._on_quiet()
        for key, payload in self._inbox.drain():
            observation = self._read(key, payload)
            if observation is not None:
                yield key, observation

    def _read(self, key: str, payload: bytes | None) -> Observation | None:
        try:
            if payload is None:
                raise MessageError("Observation", "a deletion is not an observation")
            observation = messages.decode_observation(payload)
            if keys.robot_of(key) != observation.robot:
                raise MessageError("Observation", "came on another robot's key", key)
        except MessageError as error:
            self._drops.unread(key, error)
            return None
        return observation
