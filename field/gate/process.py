"""The gate's process: its loop, which sends a twist in every period, and its end, which stops the body."""

import asyncio
import logging
import math
import secrets
import time
from typing import Any

from fes.errors import FesError, MessageError, Rejected
from fes.protocol.robot_control import HELD, MAX_CLOCK, RUNNING, GateStatus, decode_start
from fes.ros.messages import read_pose
from fes.system import signals
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from field.gate import link
from field.gate.driver import Driver
from field.gate.link import FrameSocket, PoseSeen
from field.gate.operator import Operator
from field.gate.rules import gate as rules
from field.gate.rules.gate import NANO
from field.gate.rules.pose_guard import shown
from field.gate.rules.settings import Settings
from field.gate.rules.state import ZERO, Gate, Order

PROGRESS = 0.1
"""Longest time between two states for the agent [s]."""

LOGGED = 1.0
"""Shortest time between two lines about holds [s]."""


class Process:
    """One gate between an agent and a body."""

    def __init__(self, settings: Settings, agent: FrameSocket) -> None:
        self._settings = settings
        self._agent = agent
        self._gate = Gate(secrets.randbelow(MAX_CLOCK // 2))
        self._driver: Driver | None = None
        self._operator: Operator | None = None
        self._logger = logging.getLogger(f"gate.{settings.robot}")
        self._logged = ("", -math.inf)
        self._sent = ("", "", -math.inf)

    async def run(self) -> None:
        """Open both sessions, and pass commands until the agent ends, or this task is cancelled."""
        settings, timing = self._settings, self._settings.timing
        team = Endpoints("client", settings.team, timeout=timing.patience, security=settings.team_security)
        body = Endpoints("client", (settings.body.endpoint,), timeout=timing.patience)
        loop = asyncio.get_running_loop()
        loop.add_reader(self._agent.end, self._on_agent, asyncio.current_task())
        try:
            async with bus.opened(team) as team_bus, bus.opened(body) as body_bus:
                await self._serve(team_bus, body_bus)
        finally:
            loop.remove_reader(self._agent.end)

    async def _serve(self, team: Bus, body: Bus) -> None:
        settings = self._settings
        operator = Operator(team, settings.run, settings.robot, self._absorb)
        await operator.claim()
        driver = Driver(body, settings.body, self._absorb)
        self._driver, self._operator = driver, operator
        operator.serve(self._start, self._stop, self._status)
        self._logger.info("ready, stopped until an operator starts the robot")

        def end() -> None:
            if self._gate.is_started:
                driver.put_zeros(settings.timing.period)

        with signals.if_forced(end):
            try:
                await self._live(driver)
            finally:
                end()

    async def _live(self, driver: Driver) -> None:
        """Send twists until the agent ends or this task is cancelled; then slow down."""
        reason = "the agent has ended"
        try:
            await self._loop(driver, math.inf)
        except asyncio.CancelledError as cancelled:
            reason = f"the gate is told to end: {cancelled}"
        self._gate = rules.stopped(self._gate, reason)
        limits = self._settings.limits
        slowing = limits.linear / limits.acceleration + limits.angular / limits.angular_acceleration
        await self._loop(driver, time.monotonic() + slowing)

    async def _loop(self, driver: Driver, end: float) -> None:
        """Send a twist in every period, until the agent ends, or, if there is an `end` [s], the body stands."""
        period = self._settings.timing.period
        is_ending = end < math.inf
        deadline = time.monotonic() + period
        while not (is_ending and self._gate.twist == ZERO) and time.monotonic() < end:
            await asyncio.sleep(max(0.0, deadline - time.monotonic()))
            self._absorb()
            if self._agent.is_closed and not is_ending:
                return
            now = time.monotonic()
            self._gate = rules.updated(self._gate, self._settings, now, now - deadline)
            if self._gate.is_started:
                driver.put(self._gate.twist)
            self._tell(now)
            deadline = max(deadline + period, now)

    def _on_agent(self, task: "asyncio.Task[None] | None") -> None:
        """Take the agent's commands; its end cancels a gate that still opens its sessions."""
        for frame in self._agent.receive():
            try:
                command = link.decode_command(frame)
            except MessageError as error:
                self._gate = rules.stopped(self._gate, str(error))
                continue
            heard_at = command.heard_at / NANO if command.heard_at > 0 else -math.inf
            order = Order(command.sequence, command.computed_at / NANO, command.linear, command.angular, heard_at)
            self._gate = rules.commanded(self._gate, self._settings, time.monotonic(), order)
        if self._agent.is_closed:
            asyncio.get_running_loop().remove_reader(self._agent.end)
            if self._driver is None and task is not None:
                task.cancel("the agent has ended")

    def _absorb(self) -> None:
        """Take the permits, poses and foreign commands that have arrived."""
        if self._driver is None or self._operator is None:
            return
        for received_at, permit in self._operator.permits():
            self._gate = rules.permitted(self._gate, self._settings, received_at / NANO, permit)
        for received_at, key, _ in self._driver.rivals.take():
            self._gate = rules.rivaled(self._gate, received_at / NANO, shown(key))
        for received_at, _, payload in self._driver.poses.take():
            self._pose(received_at, payload)

    def _pose(self, received_at: int, payload: bytes) -> None:
        before = self._gate.seen
        try:
            message = read_pose(self._settings.body.pose.type, payload)
        except MessageError as error:
            self._gate = rules.faulted(self._gate, f"no pose of the body: {shown(str(error))}")
            return
        self._gate = rules.posed(self._gate, self._settings, received_at / NANO, message)
        seen = self._gate.seen
        if seen is not None and seen is not before:
            self._agent.send(link.encode_pose(PoseSeen(received_at, seen.stamp, seen.pose, seen.twist)))

    def _tell(self, now: float) -> None:
        """Tell the agent the state if it has changed, or after PROGRESS; log it if a person should know."""
        status = rules.status(self._gate, self._settings, now)
        kind, logged_at = self._logged
        mode, reason, told_at = self._sent
        if (status.mode, status.reason) != (mode, reason) or now - told_at >= PROGRESS:
            self._agent.send(link.encode_progress(status))
            self._sent = (status.mode, status.reason, now)
        is_brief = HELD in (status.mode, kind) and now - logged_at < LOGGED
        if status.mode != kind and not is_brief:
            self._logger.info("%s", status.mode if status.mode == RUNNING else f"{status.mode}: {status.reason}")
            self._logged = (status.mode, now)

    def _start(self, payload: bytes) -> GateStatus:
        start = decode_start(payload)
        if self._driver is not None and self._gate.latch and self._driver.other_publishers:
            raise Rejected(f"another program can command the body: {', '.join(self._driver.other_publishers)}")
        self._absorb()
        self._gate, refusal = rules.started(self._gate, self._settings, time.monotonic(), start)
        if refusal:
            raise Rejected(refusal)
        return self._status()

    def _stop(self, _: bytes) -> GateStatus:
        self._gate = rules.stopped(self._gate, "stopped by the operator")
        return self._status()

    def _status(self, _: bytes = b"") -> GateStatus:
        return rules.status(self._gate, self._settings, time.monotonic())

    def on_error(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Stop the robot after an error in a callback, which ends no task."""
        self._gate = rules.stopped(self._gate, "an error in the gate itself")
        loop.default_exception_handler(context)


async def serve(settings: Settings, agent: FrameSocket) -> int:
    """Run a gate, and return its exit code; raises FesError."""
    opened = Process(settings, agent)
    asyncio.get_running_loop().set_exception_handler(opened.on_error)
    try:
        await opened.run()
    except asyncio.CancelledError:
        if not agent.is_closed:
            raise
        raise FesError("the agent has ended before its gate was ready") from None
    finally:
        agent.close()
    return 0
