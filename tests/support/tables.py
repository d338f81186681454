"""A table with robots in the loop of a test, and a gate's end of its drivers."""

import asyncio
import contextlib
import itertools
import os
import time
from collections.abc import AsyncIterator, Callable
from typing import Any

from fes.ros import messages, topics
from fes.ros.messages import PoseMessage
from fes.ros.topics import Topic
from fes.transport import foreign
from fes.transport.bus import Bus
from tests.support import loop
from tests.support.processes import PATIENCE
from tests.support.session import client, router
from world.config.hardware.tabletop import TabletopConfig
from world.tabletop.drivers import Drivers
from world.tabletop.process import Tabletop


class Gate:
    """The end of a robot's driver that a gate would hold."""

    def __init__(self, opened: Bus, config: TabletopConfig, robot: int) -> None:
        self._command = Topic(config.style, config.command_topic_of(robot), config.command_type, config.domain)
        pose = Topic(config.style, config.pose_topic_of(robot), config.pose_type, config.domain)
        self.keys: list[str] = []
        self.poses: list[PoseMessage] = []
        self.marks: list[bytes] = []
        self._kind = config.pose_type
        foreign.declare_subscriber(opened, topics.subscribe_key(pose), self._on_pose)
        self.put = foreign.declare_publisher(opened, topics.publish_key(self._command))
        self._count = itertools.count(1)
        self._gid = os.urandom(topics.GID_LENGTH)

    def _on_pose(self, key: str, payload: bytes, attachment: bytes) -> None:
        self.keys.append(key)
        self.poses.append(messages.read_pose(self._kind, payload))
        self.marks.append(attachment)

    def drive(self, linear: float, angular: float) -> None:
        mark = topics.attachment(self._command, next(self._count), time.time_ns(), self._gid)
        self.put(messages.write_twist(self._command.type, linear, angular), mark)


async def command(running: Tabletop, gate: Gate, linear: float, angular: float) -> None:
    """Repeat a command until the table has obeyed one: Zenoh may drop the first ones of a new publisher."""
    drivers = running.drivers
    assert drivers is not None
    before = drivers.obeyed
    async with asyncio.timeout(PATIENCE):
        while drivers.obeyed == before:
            gate.drive(linear, angular)
            await asyncio.sleep(0.02)


async def until(holds: Callable[[], Any]) -> None:
    """Wait for an effect of another thread or task."""
    async with asyncio.timeout(PATIENCE):
        while not holds():
            await asyncio.sleep(0.005)


@contextlib.asynccontextmanager
async def table(**settings: Any) -> AsyncIterator[tuple[Tabletop, Bus]]:
    """A table in real time with these settings of [tabletop], and a client of its router."""
    scenario = loop.load("tabletop.toml", **{f"tabletop__{name}": value for name, value in settings.items()})
    assert scenario.tabletop is not None
    running = Tabletop(scenario, scenario.tabletop)
    async with router() as (opened, endpoint), client(endpoint) as outside:
        running.drivers = Drivers(opened, scenario.tabletop, scenario.robots.number)
        motion = asyncio.ensure_future(running.main_loop())
        try:
            yield running, outside
        finally:
            motion.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await motion
