"""Gates and agents of real robots that only pretend: their answers, tokens and reports on a real bus."""

import asyncio
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fes.protocol import keys, robot_control, robot_report
from fes.protocol.messages import Command
from fes.protocol.robot_control import HELD, RUNNING, STOPPED, GateStatus, Permit
from fes.protocol.robot_report import Heard, RobotReport
from fes.transport.bus import Bus, Query

LAPSE = 1.0
"""Time without a Permit after which a gate stops [s]."""


def heard(peers: Sequence[int], count: int = 90, missed: int = 10, late: int = 0, estimate: float = 68.0) -> Heard:
    """The same counts of each peer."""
    ids = np.array(sorted(peers), dtype=np.int64)
    first, second, third = (np.full(len(ids), number, dtype=np.int64) for number in (count, missed, late))
    return Heard(ids, first, second, third, np.full(len(ids), estimate))


def a_robot_report(robot: int, peers: Sequence[int] = (), time: float = 10.0, **fields: Any) -> RobotReport:
    """A report of a robot on a circle of 60 m, with a link to each of `peers` and an estimate of 68 m."""
    ids = np.array(sorted(peers), dtype=np.int64)
    angle = robot * math.tau / 6
    command = Command(round(time / 0.02), robot, (1.0, 0.1), ids, np.full(len(ids), 68.0), np.zeros(0))
    report = RobotReport(
        boot=7,
        elapsed=time,
        dt=0.02,
        pose=(60.0 * math.cos(angle), 60.0 * math.sin(angle), angle),
        pose_age=0.04,
        command=command,
        reference_separation=0.0,
        beacons=heard(peers),
        mode=RUNNING,
        reason="",
    )
    return report._replace(**fields)


class FakeGate:
    """The gate of one robot: it hears Permits, and answers start, stop and status."""

    def __init__(self, bus: Bus, run: str, robot: int, deaf_to_stops: int = 0) -> None:
        """It does not answer the first `deaf_to_stops` stops."""
        self.robot, self.deaf_to_stops = robot, deaf_to_stops
        self.mode, self.reason = STOPPED, "not started"
        self.permits: list[tuple[float, Permit]] = []
        """Time [s] and content of each Permit."""
        self.asked: list[str] = []
        """Every query but those for the status."""
        self._loop = asyncio.get_running_loop()
        self._held: list[Query] = []
        bus.declare_subscriber(keys.permit(run), self._on_permit)
        for key, answer in (
            (keys.gate_start, self._start),
            (keys.gate_stop, self._stop),
            (keys.gate_status, self._answer),
        ):
            bus.declare_queryable(key(run, robot), answer)
        bus.declare_token(keys.gate_alive(run, robot))

    @property
    def state(self) -> GateStatus:
        """Its present state."""
        now = self._loop.time()
        if self.mode == RUNNING and (not self.permits or now - self.permits[-1][0] > LAPSE):
            self.mode, self.reason = STOPPED, "the permit lapsed"
        return GateStatus(self.robot, self.mode, self.reason, (1.5, -2.5, 0.5), 0.04, (0.0, 0.0), 90, 1)

    def _on_permit(self, key: str, payload: bytes | None) -> None:
        if payload is not None:
            self.permits.append((self._loop.time(), robot_control.decode_permit(payload)))

    def _start(self, query: Query) -> None:
        robot_control.decode_start(query.payload)
        self.asked.append("start")
        if self.permits and self._loop.time() - self.permits[-1][0] < LAPSE:
            self.mode, self.reason = RUNNING, ""
        else:
            self.mode, self.reason = STOPPED, "no permit"
        self._answer(query)

    def _stop(self, query: Query) -> None:
        self.asked.append("stop")
        if self.asked.count("stop") <= self.deaf_to_stops:
            self._held.append(query)  # neither an answer nor an end of the query
            return
        self.mode, self.reason = STOPPED, "stopped by the operator"
        self._answer(query)

    def _answer(self, query: Query) -> None:
        query.reply(robot_control.encode_gate_status(self.state), "GateStatus")


async def report_until_cancelled(
    bus: Bus, run: str, robot: int, peers: Sequence[int], hold: float = 0.0, boot: int = 7
) -> None:
    """Publish reports of a robot at 10 Hz, whose gate is held from `hold` [s] on if that is positive."""
    put = bus.declare_publisher(keys.robot_report(run, robot), "RobotReport", drop=True)
    bus.declare_token(keys.robot_alive(run, robot))
    ticks = 0
    while True:
        time = ticks * robot_report.PERIOD
        is_held = 0.0 < hold <= time
        report = a_robot_report(robot, peers, time, boot=boot, beacons=heard(peers, 9 * ticks, ticks))
        if is_held:
            report = report._replace(mode=HELD, reason="the pose is old")
        put(robot_report.encode_robot_report(report))
        ticks += 1
        await asyncio.sleep(robot_report.PERIOD)
