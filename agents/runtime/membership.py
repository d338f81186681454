"""Membership of an agent in a run: it joins, and confirms later that its robots are still its own."""

import asyncio
import logging
import secrets
import time
from collections.abc import Callable

from agents.runtime.world_liveliness import WorldLiveliness
from fes.errors import MessageError, Overloaded, Rejected, Unavailable
from fes.protocol import keys, messages
from fes.protocol.messages import MAX_AGENT, Join, Welcome
from fes.system import fingerprint
from fes.transport.bus import Bus
from fes.transport.inbox import Inbox

ANSWER_TIMEOUT = 5.0
"""A reachable world that does not answer a join within this time [s] is asked again."""

CONFIRMATIONS = 10
"""Number of times that an agent asks whether it is still welcome, after the world's token returned."""

PATIENCE = 1.0
"""Time [s] before an agent without an id asks again; for other agents, the scale of a spread by robot id."""


class Membership:
    """The robots of one agent in one run: requested once, and confirmed whenever the world may have another agent."""

    def __init__(self, bus: Bus, run: str, robots: tuple[int, ...], inbox: Inbox, tick: Callable[[], int]) -> None:
        """`tick` returns the last tick that was answered. A refusal after the join fails the `inbox`."""
        self.join = Join(robots, secrets.randbelow(MAX_AGENT), fingerprint.text())
        self.world = WorldLiveliness(f"the world of run '{run}'", inbox)
        self._bus, self._run, self._inbox, self._tick = bus, run, inbox, tick
        self._key = keys.welcome(run, keys.span(robots))
        self._request = messages.encode_join(self.join)
        self._welcomed = b""
        self._confirming: asyncio.Future[None] | None = None

    async def join_run(self, timeout: float) -> Welcome:
        """Wait for the world, and ask it for the robots; raises Unavailable or Rejected."""
        self._bus.declare_liveliness_subscriber(keys.world_alive(self._run), self.on_world)
        self.world.patience = timeout
        end = time.monotonic() + timeout
        while True:
            await self.world.appears(max(0.0, end - time.monotonic()))
            try:
                answer = await self._bus.get(self._key, self._request, ANSWER_TIMEOUT)
                break
            except (Unavailable, Overloaded):  # it may just have left; or all agents of a large team ask at once
                if time.monotonic() > end:
                    raise
                await asyncio.sleep(self._spread(0.0))
        welcome, self._welcomed = messages.decode_welcome(answer), answer
        if welcome.robots != self.join.robots:
            raise MessageError("Welcome", "is for other robots than asked for", str(welcome.robots[:5]))
        return welcome

    def on_quiet(self) -> None:
        """Ask after a silence whether this agent is still welcome, since its robots may be excluded."""
        if self.world.is_here and (self._confirming is None or self._confirming.done()):
            self._confirm(1)

    def on_world(self, key: str, alive: bool) -> None:
        """Handle the appearance or the loss of the world's token."""
        self.world.on_token(alive, self._tick())
        if self.world.is_new and alive:
            self._confirm(CONFIRMATIONS)

    async def confirmed(self) -> None:
        """Wait for the answer to the last question, if there is one."""
        if self._confirming is not None:
            await self._confirming

    def close(self) -> None:
        """Stop asking."""
        if self._confirming is not None:
            self._confirming.cancel()

    def _confirm(self, times: int) -> None:
        self.close()
        self._confirming = asyncio.ensure_future(self._ask_again(times))

    async def _ask_again(self, times: int) -> None:
        """Ask the world up to this many `times` whether this agent is still welcome.

        Its robots may have another agent meanwhile: this one may have been suspended past its lease.
        """
        for _ in range(times):
            try:
                answer = await self._bus.get(self._key, self._request, ANSWER_TIMEOUT)
                if self._welcomed not in (b"", answer):
                    self._inbox.fail(Rejected("another run has taken the place of this one"))
                return
            except (Unavailable, Overloaded):
                await asyncio.sleep(self._spread(1.0))
            except Rejected as refused:
                self._inbox.fail(refused)
                return
        logging.getLogger("agent").warning("the world does not say whether this agent is still welcome")

    def _spread(self, least: float) -> float:
        """Time [s] before a question is repeated: not all agents of a team at once."""
        return PATIENCE * (least + (1 + self.join.robots[0] % 10) / 10)
