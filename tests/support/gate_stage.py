"""A stage for the gate on real Zenoh sessions: router, body, operator, and an agent's commands."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Any

from console.team import permit
from fes.errors import Rejected, Unavailable
from fes.protocol import keys
from fes.protocol.robot_control import STOPPED, GateStatus, Start, decode_gate_status, encode_start
from fes.transport.bus import Bus
from field.gate.launch import AgentLink
from field.gate.link import TO_AGENT, TO_GATE, Command, FrameSocket, pair
from field.gate.process import Process
from field.gate.rules.settings import BodySettings, Settings, Timing, TopicSettings
from tests.support.processes import PATIENCE
from tests.support.ros_body import RosBody, publishing
from tests.support.session import client, router

RUN, ROBOT = "test", 3
TOPICS = TopicSettings("robot3/odom", "Odometry"), TopicSettings("robot3/cmd_vel", "Twist")

PATIENT = Timing(lateness=0.5, age=0.2, timeout=0.5, pose_age=1.0, motion_check=None, permit=3.0)
"""Times for a busy machine: only the cause that a test makes holds or stops the robot."""


def settings(endpoint: str, timing: Timing = PATIENT, **body: Any) -> Settings:
    """Settings of a gate whose team and body are at one endpoint."""
    pose, command = TOPICS
    chosen = replace(BodySettings(endpoint, pose=pose, command=command), **body)
    return Settings(ROBOT, RUN, (endpoint,), body=chosen, timing=timing)


class Operator:
    """A person with a permit, who starts and stops one robot."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._permits: asyncio.Task[None] | None = None

    def hold(self) -> None:
        """Renew the permit, as `fes team permit` does, from now on."""
        if self._permits is None:
            self._permits = asyncio.create_task(permit.publish(self._bus, RUN))

    async def leave(self) -> None:
        """Renew it no longer."""
        if self._permits is not None:
            self._permits.cancel()
            await asyncio.gather(self._permits, return_exceptions=True)
            self._permits = None

    async def start(self) -> GateStatus:
        """Start the robot; raises Rejected."""
        return await self._ask(keys.gate_start(RUN, ROBOT), encode_start(Start((await self.status()).clock)))

    async def stop(self) -> GateStatus:
        return await self._ask(keys.gate_stop(RUN, ROBOT))

    async def status(self) -> GateStatus:
        return await self._ask(keys.gate_status(RUN, ROBOT))

    async def _ask(self, key: str, payload: bytes = b"") -> GateStatus:
        return decode_gate_status(await self._bus.get(key, payload, PATIENCE))

    async def has_started(self) -> bool:
        """True if the robot is started; a gate that has no pose or permit yet refuses."""
        try:
            return (await self.start()).mode != STOPPED
        except (Rejected, Unavailable):
            return False


class Stage:
    """Everything around a gate."""

    def __init__(self, endpoint: str, chosen: Settings, body: RosBody, operator: Operator) -> None:
        self.endpoint = endpoint
        self.settings = chosen
        self.body = body
        self.operator = operator

    async def reason(self, mode: str) -> str:
        """Wait until the gate is in this mode; returns the reason."""
        async with asyncio.timeout(PATIENCE):
            while (status := await self.operator.status()).mode != mode:
                await asyncio.sleep(0.005)
        return status.reason

    async def speed(self, holds: Callable[[float], bool]) -> None:
        """Wait until the body's linear velocity fulfils a condition."""
        await until(lambda: holds(self.body.linear))


async def until(holds: Callable[[], Any]) -> None:
    """Wait for an effect in another thread or process."""
    async with asyncio.timeout(PATIENCE):
        while not holds():
            await asyncio.sleep(0.005)


@asynccontextmanager
async def stage(timing: Timing = PATIENT, **body: Any) -> AsyncIterator[Stage]:
    """A router, a body that publishes poses, and an operator who renews the permit."""
    async with router() as (_, endpoint), client(endpoint) as of_body, client(endpoint) as of_operator:
        chosen = settings(endpoint, timing, **body)
        ros_body, operator = RosBody(of_body, chosen.body), Operator(of_operator)
        operator.hold()
        try:
            async with publishing(ros_body):
                yield Stage(endpoint, chosen, ros_body, operator)
        finally:
            await operator.leave()


@asynccontextmanager
async def gate(chosen: Settings) -> AsyncIterator[AgentLink]:
    """A gate in this loop that is ready, and the agent's end of its link."""
    own, far = pair()
    end = FrameSocket(far, TO_GATE)
    task = asyncio.ensure_future(Process(chosen, end).run())
    async with AgentLink(FrameSocket(own, TO_AGENT)) as link:
        try:
            while link.progress is None and not task.done():
                await asyncio.sleep(0.005)
            if task.done():
                task.result()
            yield link
        finally:
            await link.close()
            await asyncio.wait([task])
            end.close()
        task.result()  # a gate that crashed fails its test


@asynccontextmanager
async def driving(link: AgentLink, linear: float, angular: float = 0.0) -> AsyncIterator[None]:
    """A block in which the agent commands a twist at 50 Hz."""

    async def drive() -> None:
        sequence = time.monotonic_ns()  # rises over several blocks
        while True:
            sequence += 1
            now = time.monotonic_ns()
            link.send(Command(sequence, now, linear, angular, now))
            await asyncio.sleep(0.02)

    task = asyncio.ensure_future(drive())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
