"""The registry of agents: the robots that each one hosts, and the robots whose agents are alive."""

import asyncio
import time
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools, Bytes
from fes.errors import FesError, MessageError
from fes.model.config import AgentConfig, own
from fes.protocol import keys, messages
from fes.protocol.messages import Join, Welcome
from fes.protocol.world_info import encode_world_info, of_this_process
from fes.transport.bus import Bus, Query
from fes.transport.drop_log import DropLog

RESUME_TIMEOUT = 10.0
"""A resumed world waits for its robots for this long [s], and leases them to no other agent. Agents look for the
world twice per second."""

LEASE = 5.0
"""A robot that was promised to an agent is free again if no liveliness token follows within this time [s]."""


class RunInfo(NamedTuple):
    """The run that agents join."""

    run: str
    robots: int
    """Number of robots."""
    config: AgentConfig
    """Settings that each agent receives."""


class Membership(NamedTuple):
    """The agents that joined before this world started, and the excluded robots."""

    hosts: Mapping[int, Join] = MappingProxyType({})
    """Robot -> the last Join that was accepted for it."""
    renewed: Iterable[int] = ()
    """Robots whose agents have joined, but answered no tick yet."""
    excluded: Mapping[int, str] = MappingProxyType({})
    """Robot -> the reason for its exclusion. It may change later."""


class AgentRegistry:
    """The robots of a run, and the agents that host them."""

    def __init__(
        self,
        bus: Bus,
        info: RunInfo,
        drops: DropLog,
        members: Membership,
        *,
        on_join: Callable[[Join], None],
        on_token: Callable[[int, bool], None],
    ) -> None:
        """`on_join` is called with each Join that would be accepted, and rejects it by raising a FesError.

        `on_token` is called with each robot whose token appears or is lost, and True if it appears.
        """
        self.alive: Bytes = np.zeros(info.robots, dtype=np.uint8)
        """1 for each robot with a liveliness token [n]."""
        self.changed = asyncio.Event()
        """Set whenever a token appears or is lost, or an agent cannot be accepted."""
        self.hosted: Bools = np.zeros(info.robots, dtype=np.bool_)
        """Robots whose agents were accepted and are alive, as are all robots of the same process [n]."""
        self.hosts = dict(members.hosts)
        """Robot -> the last Join that was accepted for it."""
        self.renewed = set(members.renewed)
        """Robots whose agents are new, and have not taken part yet."""
        self._info, self._drops, self._excluded = info, drops, members.excluded
        self._on_join, self._on_token = on_join, on_token
        self._promised: dict[int, float] = {}
        """Robot -> time until which it is promised to the agent that joined [s; monotonic]."""
        self._leased: dict[int, float] = dict.fromkeys(self.hosts, time.monotonic() + RESUME_TIMEOUT)
        """Robot -> time until which it is leased to no other agent [s; monotonic]."""
        bus.declare_queryable(keys.welcome(info.run, "*"), self._on_join_query)
        bus.declare_queryable(keys.lease(info.run), self._on_lease_query)
        bus.declare_queryable(
            keys.about(info.run),
            lambda query: query.reply(encode_world_info(of_this_process(info.robots)), "fes.About"),
        )
        bus.declare_liveliness_subscriber(keys.robot_alive(info.run, "*"), self._on_token_change)

    def group(self, robot: int) -> tuple[int, ...]:
        """The robots that share a process with this one: they join and leave together."""
        return self.hosts[robot].robots if robot in self.hosts else (robot,)

    def _on_lease_query(self, query: Query) -> None:
        """Lease the lowest free robot to an agent that has none; no other agent gets it while that agent joins."""
        now = time.monotonic()
        for robot in range(self._info.robots):
            if not self._refusal((robot,)) and self._leased.get(robot, 0.0) <= now:
                self._leased[robot] = now + LEASE
                query.reply(messages.encode_lease(robot), "fes.Lease")
                return
        query.reply_err(f"all {self._info.robots} robots are hosted already")

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
        is_known = all(self.hosts.get(robot) == join for robot in robots)
        fault = next((f"robot {robot} is {self._excluded[robot]}" for robot in robots if robot in self._excluded), "")
        if fault and is_known:
            # The agent asks why it gets no observations. Only another agent may host its robots from now on.
            query.reply_err(fault)
            return
        if not is_known and not self._accept(query, join):  # a known agent only asks whether it is still welcome
            return
        self._promised.update(dict.fromkeys(robots, time.monotonic() + LEASE))
        query.reply(messages.encode_welcome(Welcome(robots, own(self._info.config, robots))), "fes.Welcome")

    def _accept(self, query: Query, join: Join) -> bool:
        """Accept an agent, or refuse its query; True if it is accepted."""
        refusal = self._refusal(join.robots)
        if refusal:
            self._drops.reject("Join: refused", f"a join: {refusal}")
            query.reply_err(refusal)
            return False
        try:
            self._on_join(join)
        except FesError:
            self.changed.set()
            raise
        self.hosts.update(dict.fromkeys(join.robots, join))
        self.renewed.update(join.robots)
        return True

    def _refusal(self, robots: tuple[int, ...]) -> str:
        """Reason why no agent can have these robots now; empty if one can."""
        for robot in robots:
            if robot >= self._info.robots:
                return f"robot {robot} does not exist: this run has robots 0 to {self._info.robots - 1}"
            if self.alive[robot] and robot not in self.hosts:
                return f"robot {robot} is hosted by an agent of an earlier world"
            if self.alive[robot] or self._promised.get(robot, 0.0) > time.monotonic():
                return f"robot {robot} is hosted by another agent already"
        return ""

    def _on_token_change(self, key: str, alive: bool) -> None:
        robot = keys.robot_of(key)
        if robot is None or robot >= self._info.robots:
            self._drops.reject("liveliness: unknown robot", f"the liveliness token {key}: no such robot")
            return
        self.alive[robot] = alive
        self._promised.pop(robot, None)
        robots = range(self._info.robots)
        complete = [robot in self.hosts and self.alive[list(self.group(robot))].all() for robot in robots]
        self.hosted = np.array(complete, dtype=np.bool_)
        self.changed.set()
        self._on_token(robot, alive)
