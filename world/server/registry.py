"""Who hosts which robot, and who is alive: the world's reception desk."""

import asyncio
import logging
import time
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType

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
"""A world that goes on with a run expects its robots for this long [s], and leases them to nobody; they try to find
it twice a second."""

LEASE = 5.0
"""A robot that was promised to an agent is free again if no liveliness token follows within this time [s]."""


class AgentRegistry:
    """The robots of a run, and the agents that host them."""

    def __init__(
        self,
        bus: Bus,
        run: str,
        robots: int,
        config: AgentConfig,
        drops: DropLog,
        hosts: Mapping[int, Join] = MappingProxyType({}),
        renewed: Iterable[int] = (),
        excluded: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        """`hosts` are the Joins that were accepted before this world came, by robot; `renewed` the robots that have
        not taken part since; `excluded` maps excluded robots to the reason; it may change later.
        """
        self.alive: Bytes = np.zeros(robots, dtype=np.uint8)
        self.changed = asyncio.Event()
        """Set whenever somebody comes or goes, or cannot be accepted."""
        self.whole: Bools = np.zeros(robots, dtype=np.bool_)
        """Which robots are hosted by an agent that was accepted, and alive, with all that share their process [n]."""
        self._run = run
        self._config = config
        self._drops, self._excluded = drops, excluded
        self._logger = logging.getLogger("world")
        self._promised: dict[int, float] = {}
        self.hosts = dict(hosts)
        """The last Join that was accepted for each robot."""
        self.renewed = set(renewed)
        """Robots whose agents are new, and have not taken part yet."""
        self.on_join: Callable[[Join], None] = lambda join: None
        """Called with each Join that is to be accepted; a FesError refuses it."""
        self._leased: dict[int, float] = dict.fromkeys(self.hosts, time.monotonic() + RESUME_TIMEOUT)
        self._on_change: Callable[[int, bool], None] | None = None
        bus.declare_queryable(keys.welcome(run, "*"), self._on_join_query)
        bus.declare_queryable(keys.lease(run), self._on_lease_query)
        bus.declare_queryable(
            keys.about(run), lambda query: query.reply(encode_world_info(of_this_process(robots)), "fes.About")
        )
        bus.declare_liveliness_subscriber(keys.robot_alive(run, "*"), self._on_token)

    def report_to(self, on_token: Callable[[int, bool], None]) -> None:
        """From now on `on_token` is called with each robot that comes or goes, and whether it is alive."""
        self._on_change = on_token

    def group(self, robot: int) -> tuple[int, ...]:
        """The robots that share a process with this one: they come and go together."""
        return self.hosts[robot].robots if robot in self.hosts else (robot,)

    def _on_lease_query(self, query: Query) -> None:
        """Lease the lowest free robot to an agent that has none: nobody else is given it while it comes to join."""
        now = time.monotonic()
        for robot in range(len(self.alive)):
            if not self._refusal((robot,)) and self._leased.get(robot, 0.0) <= now:
                self._leased[robot] = now + LEASE
                query.reply(messages.encode_lease(robot), "fes.Lease")
                return
        query.reply_err(f"all {len(self.alive)} robots are hosted already")

    def _on_join_query(self, query: Query) -> None:
        try:
            join = messages.decode_join(query.payload)
        except MessageError as error:
            self._drops.unread(query.key, error)
            query.reply_err(str(error))
            return
        wanted = join.robots
        if query.key != keys.welcome(self._run, keys.span(wanted)):
            # Rules of access name keys: an agent that may ask for its own robots must not get others by asking there.
            self._drops.reject("Join: on another's key", f"{query.key}: a join of robots {keys.span(wanted)}")
            query.reply_err(f"a join of robots {keys.span(wanted)} came on {query.key}")
            return
        fault = next((f"robot {one} is {self._excluded[one]}" for one in wanted if one in self._excluded), "")
        if fault and all(self.hosts.get(robot) == join for robot in wanted):
            query.reply_err(fault)  # its agent asks why it hears nothing; only another agent may have the robot
            return
        # An agent that has joined already only asks whether it is still welcome.
        if any(self.hosts.get(robot) != join for robot in wanted):
            refusal = self._refusal(wanted)
            if refusal:
                self._drops.reject("Join: refused", f"a join: {refusal}")
                query.reply_err(refusal)
                return
            try:
                self.on_join(join)
            except FesError:
                self.changed.set()
                raise
            self.hosts.update(dict.fromkeys(wanted, join))
            self.renewed.update(wanted)
        self._promised.update(dict.fromkeys(wanted, time.monotonic() + LEASE))
        query.reply(messages.encode_welcome(Welcome(wanted, own(self._config, wanted))), "fes.Welcome")

    def _refusal(self, wanted: tuple[int, ...]) -> str:
        robots = len(self.alive)
        for robot in wanted:
            if robot >= robots:
                return f"robot {robot} does not exist: this run has robots 0 to {robots - 1}"
            if self.alive[robot] and robot not in self.hosts:
                return f"robot {robot} is hosted by an agent of an earlier world"
            if self.alive[robot] or self._promised.get(robot, 0.0) > time.monotonic():
                return f"robot {robot} is hosted by another agent already"
        return ""

    def _on_token(self, key: str, alive: bool) -> None:
        robot = keys.robot_of(key)
        if robot is None or robot >= len(self.alive):
            self._drops.reject("liveliness: unknown robot", f"the liveliness token {key}: no such robot")
            return
        self.alive[robot] = alive
        self._promised.pop(robot, None)
        complete = [one in self.hosts and self.alive[list(self.group(one))].all() for one in range(len(self.alive))]
        self.whole = np.array(complete, dtype=np.bool_)
        self.changed.set()
        if self._on_change is not None:
            self._on_change(robot, alive)
        elif not alive:
            self._logger.info("robot %d left before the start", robot)
