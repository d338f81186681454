"""The vendor's drivers of all bodies, each with keys of its own, as if every robot had its own computer."""

import os
import time
from collections import deque

from fes.arrays.types import Floats
from fes.ros import graph, messages, topics
from fes.ros.graph import Node
from fes.ros.messages import PoseMessage
from fes.ros.topics import Topic
from fes.transport import foreign
from fes.transport.bus import Bus
from world.config.hardware.tabletop import TabletopConfig
from world.tabletop.bodies.interface import Bodies
from world.tabletop.held_command import Arrival, HeldCommand

WAITING = 64
"""Commands of one robot that wait for the next cycle; when there are more the oldest is dropped."""


class Driver:
    """The driver of one robot: it hears commands and reports poses."""

    def __init__(self, opened: Bus, config: TabletopConfig, robot: int) -> None:
        command = Topic(config.style, config.command_topic_of(robot), config.command_type, config.domain)
        self._pose = Topic(config.style, config.pose_topic_of(robot), config.pose_type, config.domain)
        self._frame = config.frame
        self._arrivals: deque[Arrival] = deque(maxlen=WAITING)
        self._sequence, self._gid = 0, os.urandom(topics.GID_LENGTH)
        self.held = HeldCommand(config)
        foreign.declare_subscriber(opened, topics.subscribe_key(command), self._on_command)
        self._put = foreign.declare_publisher(opened, topics.publish_key(self._pose))
        node = Node(foreign.session_id(opened), f"driver{robot}", domain=config.domain)
        for token in graph.tokens(node, [self._pose], [command]):
            opened.declare_token(token)

    def _on_command(self, key: str, payload: bytes, attachment: bytes) -> None:
        """Only hand over: this is a thread of Zenoh."""
        self._arrivals.append(Arrival(time.monotonic(), payload, attachment))

    def obey(self, now: float) -> tuple[float, float]:
        """The twist to hold from the time `now` on [s; monotonic], after the commands that have arrived."""
        for _ in range(len(self._arrivals)):
            self.held.hear(self._arrivals.popleft())
        return self.held.twist(now)

    def report(self, pose: list[float], twist: list[float], stamp: int) -> None:
        """Publish the pose [m, m, rad; table frame] and the twist [m/s, rad/s; body frame] of a time [ns]."""
        self._sequence += 1
        x, y, heading = pose
        linear, angular = twist
        message = PoseMessage(stamp, self._frame, x, y, heading, (linear, angular))
        mark = topics.attachment(self._pose, self._sequence, stamp, self._gid)
        self._put(messages.write_pose(self._pose.type, message), mark)


class Drivers:
    """The drivers of a team; their reports are spread over the period of the poses, as those of real robots are."""

    def __init__(self, opened: Bus, config: TabletopConfig, robots: int) -> None:
        self._period = config.steps_per_pose // config.steps_per_cycle
        self._drivers = [Driver(opened, config, robot) for robot in range(robots)]

    @property
    def obeyed(self) -> int:
        """Commands that they have obeyed."""
        return sum(driver.held.obeyed for driver in self._drivers)

    @property
    def ignored(self) -> int:
        """Samples that they could not read."""
        return sum(driver.held.ignored for driver in self._drivers)

    def obey(self, bodies: Bodies, now: float) -> None:
        """Let all bodies hold the commands that have arrived by the time `now` [s; monotonic]."""
        for robot, driver in enumerate(self._drivers):
            bodies.command(robot, *driver.obey(now))

    def report(self, cycle: int, poses: Floats, twists: Floats, stamp: int) -> None:
        """Publish the poses [n, 3] of the robots due at this cycle, stamped with a time [ns]."""
        for robot in range(cycle % self._period, len(self._drivers), self._period):
            self._drivers[robot].report(poses[robot].tolist(), twists[robot].tolist(), stamp)
