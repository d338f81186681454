"""The agents that host the robots of a run: leases, joins and liveliness tokens, and robots at fault.

The first half of the life cycle in `world.execution.lifecycle`, and a pure state machine as it is.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools, Bytes
from fes.protocol.messages import Join

RESUME_TIMEOUT = 10.0
"""A resumed world waits for its robots for this long [s], and leases them to no other agent. Agents look for the
world twice per second."""

LEASE = 5.0
"""A robot that was promised to an agent is free again if no liveliness token follows within this time [s]."""

NEVER = -np.inf
"""The end of a promise or a lease that was not made [s]."""


class Membership(NamedTuple):
    """The agents that joined before this world started, and the excluded robots."""

    hosts: Mapping[int, Join] = MappingProxyType({})
    """Robot -> the last Join that was accepted for it."""
    renewed: Iterable[int] = ()
    """Robots whose agents have joined, but answered no tick yet."""
    excluded: Mapping[int, str] = MappingProxyType({})
    """Robot -> the reason for its exclusion."""


class Admission(NamedTuple):
    """The answer to a Join."""

    refusal: str
    """Reason why the agent cannot have its robots; empty if it is welcome."""
    is_known: bool
    """True if the agent hosts its robots already, and asks whether it is still welcome."""


class Hosting:
    """The agents of all robots of a run."""

    def __init__(self, robots: int, members: Membership, now: float) -> None:
        """Each robot of `members` is leased to no other agent for RESUME_TIMEOUT."""
        self._robots = robots
        accepted: dict[Join, Join] = {}
        self.hosts = {robot: accepted.setdefault(join, join) for robot, join in members.hosts.items()}
        """Robot -> the last Join that was accepted for it; the same object for all of its robots."""
        self.renewed = set(members.renewed)
        """Robots whose agents are new, and have not taken part yet."""
        self.excluded = dict(members.excluded)
        """Robot -> its fault, until another agent joins for it."""
        self.promised: dict[int, float] = {}
        """Robot -> time until which it is promised to the agent that joined [s]."""
        self.leased = dict.fromkeys(self.hosts, now + RESUME_TIMEOUT)
        """Robot -> time until which it is leased to no other agent [s]."""
        self.alive: Bytes = np.zeros(robots, dtype=np.uint8)
        """1 for each robot with a liveliness token [n]."""
        self.hosted: Bools = np.zeros(robots, dtype=np.bool_)
        """Robots whose agents were accepted and are alive, as are all robots of the same process [n]."""
        self._joins: dict[int, list[Join]] = defaultdict(list)
        """Robot -> the accepted Joins that name it, and that are still the last one of some robot."""
        for join in accepted:
            self._index(join)

    @property
    def able(self) -> Bools:
        """Robots that are hosted and not excluded [n]."""
        able = self.hosted.copy()
        if self.excluded:
            able[list(self.excluded)] = False
        return able

    def group(self, robot: int) -> tuple[int, ...]:
        """The robots that share a process with this one: they join and leave together."""
        return self.hosts[robot].robots if robot in self.hosts else (robot,)

    def judge(self, join: Join, now: float) -> Admission:
        """The answer to a Join, which has no effect yet."""
        is_known = all(self.hosts.get(robot) == join for robot in join.robots)
        if not is_known:
            return Admission(self._refusal(join.robots, now), is_known)
        # The agent asks why it gets no observations. Only another agent may host its robots from now on.
        faults = (f"robot {robot} is {self.excluded[robot]}" for robot in join.robots if robot in self.excluded)
        return Admission(next(faults, ""), is_known)

    def lease(self, now: float) -> int | None:
        """Lease the lowest free robot to an agent that has none; no other agent gets it while that agent joins."""
        for robot in range(self._robots):
            if not self._refusal((robot,), now) and self.leased.get(robot, NEVER) <= now:
                self.leased[robot] = now + LEASE
                return robot
        return None

    def join(self, join: Join, now: float) -> Admission:
        """Accept an agent, or refuse it; the robots of an agent that is welcome are promised to it for LEASE."""
        admission = self.judge(join, now)
        if not admission.refusal:
            if not admission.is_known:
                self._accept(join)
            self.promised.update(dict.fromkeys(join.robots, now + LEASE))
        return admission

    def token(self, robot: int, alive: bool) -> None:
        """The token of a robot has appeared, or was lost."""
        self.alive[robot] = alive
        self.promised.pop(robot, None)
        for join in self._joins[robot]:
            members = [member for member in join.robots if self.hosts.get(member) is join]
            self.hosted[members] = self.alive[list(join.robots)].all()

    def exclude(self, faults: Mapping[int, str]) -> None:
        """Exclude robots for their faults, until another agent joins for them."""
        self.excluded.update(faults)

    def _refusal(self, robots: tuple[int, ...], now: float) -> str:
        """Reason why no agent can have these robots now; empty if one can."""
        for robot in robots:
            if robot >= self._robots:
                return f"robot {robot} does not exist: this run has robots 0 to {self._robots - 1}"
            if self.alive[robot] and robot not in self.hosts:
                return f"robot {robot} is hosted by an agent of an earlier world"
            if self.alive[robot] or self.promised.get(robot, NEVER) > now:
                return f"robot {robot} is hosted by another agent already"
        return ""

    def _accept(self, join: Join) -> None:
        """Let an agent host its robots, none of which is alive, instead of the agents that hosted them before."""
        before = {id(host): host for robot in join.robots if (host := self.hosts.get(robot)) is not None}
        self.hosts.update(dict.fromkeys(join.robots, join))
        self.renewed.update(join.robots)
        for robot in join.robots:
            self.excluded.pop(robot, None)
        for host in before.values():
            if not any(self.hosts.get(robot) is host for robot in host.robots):
                for robot in host.robots:
                    self._joins[robot].remove(host)
        self._index(join)

    def _index(self, join: Join) -> None:
        for robot in join.robots:
            self._joins[robot].append(join)
