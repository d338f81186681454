"""Membership of an agent in a run: the join, and later confirmations that its robots are still assigned to it."""

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
from fes.transport.inbox import ThreadInbox

ANSWER_TIMEOUT = 5.0
"""Time [s] that a request waits for the answer of the world. Then it is repeated."""

CONFIRMATIONS = 10
"""Largest number of requests for one confirmation, after the world's token returned."""

PATIENCE = 1.0
"""Pause [s] before an agent without an id requests a lease again. For agents with an id, the unit of the pause before
a repeated request, which depends on the robot."""


class Membership:
    """The robots of one agent in one run.

    The agent requests them once. It confirms them whenever the world may have assigned them to another agent.
    """

    def __init__(
        self, bus: Bus, run: str, robots: tuple[int, ...], inbox: ThreadInbox, tick: Callable[[], int]
    ) -> None:
        """`tick` returns the last tick that this agent answered. A rejection after the join fails the `inbox`."""
        self.join = Join(robots, secrets.randbelow(MAX_AGENT), fingerprint.text())
        self.world = WorldLiveliness(f"the world of run '{run}'", inbox)
        self._bus, self._run, self._inbox, self._tick = bus, run, inbox, tick
        self._key = keys.welcome(run, keys.span(robots))
        self._request = messages.encode_join(self.join)
        self._welcomed = b""
        self._confirming: asyncio.Future[None] | None = None

    async def join_run(self, timeout: float) -> Welcome:
        """Wait for the world up to `timeout` [s], and request the robots.

        Raises Unavailable, Rejected, or MessageError for a Welcome that cannot be used.
        """
        self._bus.declare_liveliness_subscriber(keys.world_alive(self._run), self.on_world)
        self.world.patience = timeout
        end = time.monotonic() + timeout
        while True:
            await self.world.wait(max(0.0, end - time.monotonic()))
            try:
                answer = await self._bus.get(self._key, self._request, ANSWER_TIMEOUT)
                break
            except (Unavailable, Overloaded):  # the world just left, or a large team joins all at once
                if time.monotonic() > end:
                    raise
                await asyncio.sleep(self._pause(0.0))
        welcome, self._welcomed = messages.decode_welcome(answer), answer
        if welcome.robots != self.join.robots:
            raise MessageError("Welcome", "is for other robots than requested", str(welcome.robots[:5]))
        return welcome

    def on_quiet(self) -> None:
        """Confirm the membership after a silence, since the world may have excluded the robots."""
        if self.world.is_alive and (self._confirming is None or self._confirming.done()):
            self._confirm(1)

    def on_world(self, key: str, alive: bool) -> None:
        """Handle the appearance or the loss of the world's token."""
        self.world.on_token(alive, self._tick())
        if self.world.is_new and alive:
            self._confirm(CONFIRMATIONS)

    async def confirmed(self) -> None:
        """Wait until the current confirmation ends, if there is one."""
        if self._confirming is not None:
            await self._confirming

    def close(self) -> None:
        """Cancel the current confirmation, if there is one."""
        if self._confirming is not None:
            self._confirming.cancel()

    def _confirm(self, attempts: int) -> None:
        """Start a confirmation, in place of the current one."""
        self.close()
        self._confirming = asyncio.ensure_future(self._repeat_join(attempts))

    async def _repeat_join(self, attempts: int) -> None:
        """Send the Join again, up to `attempts` times, and fail the inbox unless the answer is the same Welcome.

        This process may have been suspended past Zenoh's lease, and its robots may have another agent since then.
        """
        for _ in range(attempts):
            try:
                answer = await self._bus.get(self._key, self._request, ANSWER_TIMEOUT)
                if self._welcomed not in (b"", answer):
                    self._inbox.fail(Rejected("another run has taken the place of this one"))
                return
            except (Unavailable, Overloaded):
                await asyncio.sleep(self._pause(1.0))
            except Rejected as rejection:
                self._inbox.fail(rejection)
                return
        logging.getLogger("agent").warning("the world does not say whether this agent is still welcome")

    def _pause(self, least: float) -> float:
        """Pause [s] before a repeated request, `least` in units of PATIENCE: the agents of a team spread theirs."""
        return PATIENCE * (least + (1 + self.join.robots[0] % 10) / 10)
