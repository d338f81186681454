"""A driver of ROS 2 and its bridge as processes beside a Zenoh router: `async with driven(...) as stage`."""

import asyncio
import json
import os
import sys
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import Any, NamedTuple

from tests.support.paths import ROOT
from tests.support.processes import PATIENCE

DOMAIN = 60 + os.getpid() % 40
"""An unusual ROS_DOMAIN_ID whose ports are below those that the kernel hands out."""

LONGEST_END = 10.0  # s; then a process is killed

ENVIRONMENT = {
    **os.environ,
    "ROS_DOMAIN_ID": str(DOMAIN),
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",  # a killed process would leave files of shared memory
    "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
    "PYTHONPATH": str(ROOT),
}


class Robot(NamedTuple):
    """The name of a robot, and the types of its two topics."""

    name: str
    twist: str
    pose: str


class Stage:
    """Lines of the driver so far."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.hashes: list[str] = []
        """Of the twist and of the pose, once both topics are matched."""
        self.heard: list[list[Any]] = []
        """Twists: linear, angular and, if stamped, time [ns] and frame."""
        self.published: dict[int, list[float]] = {}
        """Poses and twists by their stamp [ns]: x, y, heading, linear, angular."""
        self._changed = asyncio.Event()
        self._has_ended = False

    async def listen(self, lines: asyncio.StreamReader) -> None:
        """Take the driver's lines until it ends."""
        async for line in lines:
            fields = json.loads(line)
            self.hashes += fields.get("matched", [])
            if "heard" in fields:
                self.heard.append(fields["heard"])
            if "published" in fields:
                stamp, *pose = fields["published"]
                self.published[stamp] = pose
            self._changed.set()
        self._has_ended = True
        self._changed.set()

    async def changed(self) -> None:
        """Wait for the driver's next line; raises RuntimeError if it has ended."""
        if self._has_ended:
            raise RuntimeError("the driver has ended")
        self._changed.clear()
        async with asyncio.timeout(PATIENCE):
            await self._changed.wait()


@asynccontextmanager
async def driven(robot: Robot, endpoint: str) -> AsyncIterator[Stage]:
    """A driver and a bridge that is a client of the router at `endpoint`; both topics are matched."""
    stage = Stage(robot)
    async with AsyncExitStack() as stack:
        driver = await stack.enter_async_context(_process("tests.robots.driver", *robot))
        await stack.enter_async_context(_process("tests.robots.bridge", endpoint, *robot))
        assert driver.stdout
        listening = asyncio.create_task(stage.listen(driver.stdout))
        try:
            async with asyncio.timeout(PATIENCE):
                while not stage.hashes:
                    await stage.changed()
            yield stage
        finally:
            listening.cancel()
            with suppress(asyncio.CancelledError):
                await listening


@asynccontextmanager
async def _process(module: str, *words: str) -> AsyncIterator[asyncio.subprocess.Process]:
    """A process that ends with its standard input."""
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", module, *words, cwd=ROOT, env=ENVIRONMENT, stdin=pipe, stdout=pipe
    )
    try:
        yield process
    finally:
        assert process.stdin
        process.stdin.close()
        with suppress(TimeoutError):
            await asyncio.wait_for(process.communicate(), LONGEST_END)
        if process.returncode is None:
            process.kill()
            await process.wait()
