"""The registry of agents on the bus: leases, joins and liveliness tokens, for the robots' life cycles."""

import asyncio
import contextlib
import time
from collections.abc import Callable
from typing import NamedTuple

from fes.arrays.types import Bools
from fes.errors import FesError, MessageError
from fes.model.config import AgentConfig, own
from fes.protocol import keys, messages
from fes.protocol.messages import Join, Welcome
from fes.protocol.world_info import encode_world_info, of_this_process
from fes.transport.bus import Bus, Query
from fes.transport.drop_log import DropLog
from world.execution.lifecycle import Lifecycle


class RunInfo(NamedTuple):
    """The run that agents join."""

    run: str
    robots: int
    """Number of robots."""
    config: AgentConfig
    """Settings that each agent receives."""


class AgentRegistry:
    """The queries and liveliness tokens of agents, as events of the robots' life cycles."""

    def __init__(
        self,
        bus: Bus,
        info: RunInfo,
        drops: DropLog,
        lifecycle: Lifecycle,
        *,
        on_join: Callable[[Join], None],
        on_token: Callable[[int, bool], None],
    ) -> None:
        """`on_join` is called with each Join that would be accepted, and rejects it by raising a FesError.

        `on_token` is called with each robot whose token has appeared or was lost, and True if it appeared.
        """
        self.changed = asyncio.Event()
        """Set whenever a token appears or is lost, or an agent cannot be accepted."""
        self._info, self._drops, self._lifecycle = info, drops, lifecycle
        self._on_join, self._on_token = on_join, on_token
        bus.declare_queryable(keys.welcome(info.run, "*"), self._on_join_query)
        bus.declare_queryable(keys.lease(info.run), self._on_lease_query)
        bus.declare_queryable(
            keys.about(info.run),
            lambda query: query.reply(encode_world_info(of_this_process(info.robots)), "fes.About"),
        )
        bus.declare_liveliness_subscriber(keys.robot_alive(info.run, "*"), self._on_token_change)

    async def wait_for(self, robots: Bools, timeout: float) -> None:
        """Wait until `robots` [n] are reachable, for up to `timeout` [s]."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                while not self._lifecycle.reachable[robots].all():
                    self.changed.clear()
                    await self.changed.wait()

    def _on_lease_query(self, query: Query) -> None:
        robot = self._lifecycle.hosting.lease(time.monotonic())
        if robot is None:
            query.reply_err(f"all {self._info.robots} robots are hosted already")
            return
        query.reply(messages.encode_lease(robot), "fes.Lease")

    def _on_join_query(self, query: Query) -> None:
        try:
            join = messages.decode_join(query.payload)
        except MessageError as error:
            self._drops.unread(query.key, error)
            query.reply_err(str(error))
            return
        robots = join.robots
        if query.key != keys.welcome(self._info.run, keys.span(robots)):
            # Access rules name keys: an agent must not get other robots by a join on the key of its own.
            self._drops.reject("Join: on another's key", f"{query.key}: a join of robots {keys.span(robots)}")
            query.reply_err(f"a join of robots {keys.span(robots)} came on {query.key}")
            return
        now, hosting = time.monotonic(), self._lifecycle.hosting
        admission = hosting.judge(join, now)
        if not (admission.refusal or admission.is_known):
            self._note(join)
        elif admission.refusal and not admission.is_known:
            self._drops.reject("Join: refused", f"a join: {admission.refusal}")
        if admission.refusal:
            query.reply_err(admission.refusal)
            return
        hosting.join(join, now)
        query.reply(messages.encode_welcome(Welcome(robots, own(self._info.config, robots))), "fes.Welcome")

    def _note(self, join: Join) -> None:
        """Report an agent that is about to be accepted; raises FesError."""
        try:
            self._on_join(join)
        except FesError:
            self.changed.set()
            raise

    def _on_token_change(self, key: str, alive: bool) -> None:
        robot = keys.robot_of(key)
        if robot is None or robot >= self._info.robots:
            self._drops.reject("liveliness: unknown robot", f"the liveliness token {key}: no such robot")
            return
        self._lifecycle.token(robot, alive)
        self.changed.set()
        self._on_token(robot, alive)
