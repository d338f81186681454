"""Our side of a robot: it speaks only `fes.ros` and `fes.transport.foreign`, and records what it sent and read."""

import asyncio
import math
from typing import NamedTuple

from fes.ros.messages import PoseMessage, read_pose, write_twist
from fes.ros.topics import Topic, publish_key, subscribe_key
from fes.transport import foreign
from fes.transport.bus import Bus
from tests.robots.stage import Stage
from tests.support.processes import PATIENCE

COMMANDS = 150
"""Commands of a drive: 3 s at the driver's rate."""

STAMP = 1_700_000_000_123_456_789
"""Time of the first command [ns]: any, since this driver does not look at it."""

FRAME = "base_link"


class Drive(NamedTuple):
    """A drive: twists with their times, and poses."""

    sent: list[tuple[float, float, int]]
    poses: list[PoseMessage]


async def drive(bus: Bus, stage: Stage, count: int = COMMANDS) -> Drive:
    """Send `count` different commands, one after each pose, each again until the driver has heard it."""
    robot = stage.robot
    loop = asyncio.get_running_loop()
    payloads: asyncio.Queue[bytes] = asyncio.Queue()

    def on_pose(key: str, payload: bytes, attachment: bytes) -> None:
        loop.call_soon_threadsafe(payloads.put_nowait, payload)

    foreign.declare_subscriber(bus, subscribe_key(Topic("ros2dds", f"/{robot.name}/odom", robot.pose)), on_pose)
    put = foreign.declare_publisher(bus, publish_key(Topic("ros2dds", f"/{robot.name}/cmd_vel", robot.twist)))

    def send(linear: float, angular: float, stamp: int) -> None:
        put(write_twist(robot.twist, linear, angular, stamp, FRAME), b"")

    done = Drive([], [])
    async with asyncio.timeout(PATIENCE):
        while not stage.heard:  # until the way is open; the driver may not hear the first of these
            await payloads.get()
            send(0.0, 0.0, 0)
        for number in range(count):
            done.poses.append(read_pose(robot.pose, await payloads.get()))
            twist = (0.1 + number / 1000, math.sin(number / 10), STAMP + number * 20_000_000)
            done.sent.append(twist)
            while [*twist[:2]] not in [known[:2] for known in stage.heard[-2:]]:  # a busy network drops some
                send(*twist)
                await payloads.get()
        while done.poses[-1].stamp not in stage.published:
            await stage.changed()  # what the driver says of the last pose
    return done
