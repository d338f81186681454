"""The ticks at which an agent steps: every tick in lockstep, the newest with a live clock."""

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
"""An agent that receives nothing from a living world for this long [s] exits."""

QUIET = 5.0
"""After each silence of this length [s] an agent confirms its membership."""


class TickSource:
    """Iterators over the ticks to answer. Each tick is a list of observations, one per robot in id order."""

    def __init__(
        self,
        robots: tuple[int, ...],
        inbox: Inbox,
        outbox: Outbox,
        drops: DropLog,
        on_quiet: Callable[[], None] = lambda: None,
    ) -> None:
        """`on_quiet` is called after each silence of QUIET [s]."""
        self._robots, self._on_quiet = robots, on_quiet
        self._inbox, self._outbox = inbox, outbox
        self._drops = drops
        self.tick = -1
        """The last tick yielded."""
        self._forgotten = -1
        self.skipped = 0
        """Number of ticks that the live clock skipped, because a newer one had arrived."""

    async def lockstep(self, world: WorldLiveliness) -> AsyncIterator[list[Observation]]:
        """Yield every tick, until the run is over; answer a repeated tick from the outbox. Raises Unavailable."""
        waiting: dict[int, Observation] = {}
        while True:
            async for key, observation in self._received(len(self._robots) - len(waiting)):
                if observation.over:
                    return
                if observation.tick > self.tick + 1 and observation.since == observation.tick:
                    self.tick = observation.tick - 1  # the run continued without this agent
                    waiting.clear()
                if observation.tick == self.tick + 1:
                    waiting.setdefault(observation.robot, observation)
                elif observation.tick == self.tick or (world.is_new and observation.tick < self.tick):
                    # A restarted world repeats its last tick, or the one before. The outbox still holds both.
                    if self._outbox.has(observation.tick):
                        self._outbox.resend(observation.tick, observation.robot)
                    elif observation.tick < self.tick:
                        self._behind(key, observation.tick)
                elif self.tick >= 0:  # an agent that has joined may have to wait for its first tick
                    self._drops.reject("Observation: is not for this tick", f"{key}: tick {observation.tick}")
            if len(waiting) == len(self._robots):
                self.tick += 1
                world.is_new = False
                yield [waiting[robot] for robot in self._robots]
                waiting.clear()

    async def live(self, world: WorldLiveliness) -> AsyncIterator[list[Observation]]:
        """Yield the newest tick of which all observations have arrived, until the run is over. Raises Unavailable."""
        newest: dict[int, dict[int, Observation]] = {}
        while True:
            async for _, observation in self._received(1):
                if observation.over:
                    return
                if world.is_new and observation.tick <= self.tick:
                    self.tick = observation.tick - 1  # the world resumed from an earlier tick
                world.is_new = False
                if observation.tick > self.tick:
                    newest.setdefault(observation.tick, {})[observation.robot] = observation
            complete = [tick for tick, by_robot in newest.items() if len(by_robot) == len(self._robots)]
            if complete:
                tick, before = max(complete), self.tick
                observations = [newest[tick][robot] for robot in self._robots]
                newest = {later: by_robot for later, by_robot in newest.items() if later > tick}
                if before >= 0 and observations[0].since <= before:
                    self.skipped += tick - before - 1
                self.tick = tick
                yield observations

    def _behind(self, key: str, tick: int) -> None:
        """Handle a restarted world's request for a tick that is not stored; raises Unavailable at the second one."""
        if tick == self._forgotten:
            raise Unavailable(f"the world is back at tick {tick}, but tick {self.tick} was answered already")
        self._forgotten = tick
        self._drops.reject("Observation: is not for this tick", f"{key}: tick {tick}")

    async def _received(self, count: int) -> AsyncIterator[tuple[str, Observation]]:
        """Wait for `count` messages; yield key and content of all messages that have arrived and can be decoded."""
        end = time.monotonic() + SILENCE_TIMEOUT
        while not await self._inbox.wait(count, QUIET):
            if time.monotonic() >= end:
                raise Unavailable(f"the world sent nothing for {SILENCE_TIMEOUT:g} s after tick {self.tick}")
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
