"""A body for tests of the gate: a unicycle that speaks ROS 2 bytes, and holds its last command for ever."""

import asyncio
import math
import threading
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import NamedTuple

from fes.ros import topics
from fes.ros.messages import PoseMessage, read_twist, write_pose
from fes.transport import foreign
from fes.transport.bus import Bus
from field.gate.rules.settings import BodySettings

PERIOD = 0.02
"""Period of the poses [s]."""

GID = bytes(range(16))


class Received(NamedTuple):
    """A command that the body has received."""

    time: float
    """[s, monotonic]"""
    linear: float
    angular: float
    travelled: float
    """Distance that it has travelled by then [m]."""


class RosBody:
    """A body, and everything that it was commanded."""

    def __init__(self, bus: Bus, settings: BodySettings) -> None:
        self.received: list[Received] = []
        self.attachments: list[bytes] = []
        self.shift = 0.0
        """Added to x of the poses: a jump [m]."""
        self.frame = settings.frame
        self.pose_type = settings.pose.type
        """Type of the bytes of its poses."""
        self.gain = 1.0
        """Factor of its linear velocity: 0 for wheels without power."""
        self.is_silent = False
        """True while it publishes no pose."""
        self._settings = settings
        self._lock = threading.Lock()
        self._pose = [0.0, 0.0, 0.0]
        self._twist = (0.0, 0.0)
        self._travelled = 0.0
        self._moved = time.monotonic()
        self._sequence = 0
        self._put = foreign.declare_publisher(bus, topics.publish_key(settings.pose_topic))
        foreign.declare_subscriber(bus, topics.subscribe_key(settings.command_topic), self._on_command)

    @property
    def linear(self) -> float:
        """Linear velocity now [m/s]."""
        return self.gain * self._twist[0]

    @property
    def travelled(self) -> float:
        """Length of its path up to now [m]."""
        with self._lock:
            self._move(time.monotonic())
            return self._travelled

    async def publish(self) -> None:
        """Publish poses until this task is cancelled."""
        while True:
            with self._lock:
                self._move(time.monotonic())
                x, y, heading = self._pose
            self._sequence += 1
            now = time.time_ns()
            message = PoseMessage(now, self.frame, x + self.shift, y, heading)
            mark = topics.attachment(self._settings.pose_topic, self._sequence, now, GID)
            if not self.is_silent:
                self._put(write_pose(self.pose_type, message), mark)
            await asyncio.sleep(PERIOD)

    def _on_command(self, key: str, payload: bytes, attachment: bytes) -> None:
        now = time.monotonic()
        twist = read_twist(self._settings.command.type, payload)
        with self._lock:
            self._move(now)
            self._twist = twist
            self.received.append(Received(now, *twist, self._travelled))
            self.attachments.append(attachment)

    def _move(self, now: float) -> None:
        dt, self._moved = now - self._moved, now
        linear, angular = self.gain * self._twist[0], self._twist[1]
        x, y, heading = self._pose
        middle = heading + angular * dt / 2
        self._pose = [x + linear * dt * math.cos(middle), y + linear * dt * math.sin(middle), heading + angular * dt]
        self._travelled += abs(linear) * dt


@asynccontextmanager
async def publishing(body: RosBody) -> AsyncIterator[None]:
    """A block in which a body publishes its poses."""
    task = asyncio.ensure_future(body.publish())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
