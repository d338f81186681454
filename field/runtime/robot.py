"""The loop of a real robot: at each tick, from the last pose and what was heard to a beacon and a command."""

import asyncio
import logging
import time
from collections.abc import Callable

from fes.errors import FesError, MessageError, Unavailable
from fes.model import counts
from fes.protocol import messages
from fes.protocol.robot_control import RUNNING
from fes.protocol.robot_report import encode_robot_report
from fes.protocol.sealed import Sealed
from fes.recording.robot_log.recorder import RobotLog
from field.gate.launch import AgentLink
from field.gate.link import Command, Progress
from field.radio import wall_clock
from field.radio.socket import Radio
from field.runtime import reports, stepper
from field.runtime.fixes import Fixes, Pose
from field.runtime.participation import LONGEST_GAP, Participation
from field.runtime.reports import Reporter
from field.runtime.stepper import Step, Stepper
from field.runtime.tick_clock import TickClock
from field.senses.senses import Senses
from field.settings.robot_file import RobotFile

STILL = (0.0, 0.0)

MEMORY = 2.0
"""Time for which a silent peer counts as in range [s]."""


class Robot:
    """A robot that is connected to its gate and its radio."""

    def __init__(self, file: RobotFile, robot: int, boot: int, publish: Callable[[bytes], None]) -> None:
        """`publish` puts a RobotReport; it must not wait."""
        self.logger = logging.getLogger(f"robot.{robot}")
        self.senses = Senses(robot, counts.ticks(MEMORY, file.dt))
        self.skipped = 0
        """Ticks without a step, because the process was suspended."""
        self._clock = TickClock(file.dt, wall_clock.ahead(), 0)
        stepper.warm_up(file.agent_config, robot)
        self._stepper = Stepper(file.agent_config, robot, self.senses)
        self._fixes, self._participation = Fixes(self._clock.period), Participation()
        self._reporter = Reporter(robot, boot, file.dt, file.seeking, self.senses)
        self._publish, self._born = publish, time.monotonic_ns()
        self._progress: Progress | None = None
        self._twist, self._heard_at, self._reported_at = STILL, 0, 0
        self._unreadable = self._unsent = 0
        self._pose_age = round(1e9 * file.limits.pose_age)

    def hear(self, sealed: Sealed, arrived: int) -> None:
        """Take a datagram of a peer that arrived at a time [ns; monotonic]."""
        try:
            beacon = messages.decode_beacon(sealed.payload)
        except MessageError as error:
            if not self._unreadable:
                self.logger.warning("a beacon of robot %d cannot be read: %s", sealed.robot, error)
            self._unreadable += 1
            return
        self._heard_at = arrived
        if self._participation.since is None:  # it starts anew, and no step would take the beacon
            return
        tick = self._clock.tick(arrived)
        share = (arrived - self._clock.start(tick)) / self._clock.period
        self.senses.hear(sealed, beacon, tick + share)

    async def live(self, gate: AgentLink, radio: Radio, log: RobotLog | None) -> None:
        """Step at each tick; raises Unavailable when the gate has ended.

        A tick that comes late is answered late, so that its peers miss no beacon. Only the command of the newest tick
        goes to the gate.
        """
        gate.sleep()
        tick = self._clock.tick(time.monotonic_ns()) + 1
        while True:
            now = time.monotonic_ns()
            ahead = self._clock.start(tick) - now
            await asyncio.sleep(max(0.0, 1e-9 * ahead))  # also a late tick lets signals in
            if -ahead > LONGEST_GAP:
                newest = self._clock.tick(now)
                self.skipped, tick = self.skipped + newest - tick, newest
            radio.receive()
            self._read(gate, log)
            step = self._step(tick)
            if step is not None:
                self._act(tick, step, gate, radio, log)
            self._report(tick, step)
            tick += 1

    def _read(self, gate: AgentLink, log: RobotLog | None) -> None:
        """Take the poses and the state that the gate has sent; raises Unavailable if it has ended."""
        for seen in gate.take():
            self._fixes.add(Pose(seen.received_at, seen.pose))
        if gate.is_closed:
            raise Unavailable("the gate has ended: only the driver's own timeout stops the robot now")
        before, after = self._progress, gate.progress
        self._progress = after
        if after is not None and (before is None or (before.mode, before.reason) != (after.mode, after.reason)):
            self.logger.info("the gate is %s%s", after.mode, f": {after.reason}" * bool(after.reason))
            if log is not None:
                log.event("gate", f"{after.mode} {after.reason}".strip(), mode=after.mode, reason=after.reason)

    def _step(self, tick: int) -> Step | None:
        """The step of a tick; None while the robot does not take part."""
        start, mode = self._clock.start(tick), "" if self._progress is None else self._progress.mode
        fix = self._fixes.fix(tick, start, self._twist if mode == RUNNING else STILL)
        since = self._participation.step(tick, start, mode, None if fix is None else self._fixes.age(start))
        if since is None or fix is None:
            self._twist = STILL
            return None
        return self._stepper.step(tick, fix, since)

    def _act(self, tick: int, step: Step, gate: AgentLink, radio: Radio, log: RobotLog | None) -> None:
        """Send the beacon and the command. A command from an old pose stays here: the gate could not tell."""
        self._send(step.beacon, radio)
        start, now = self._clock.start(tick), time.monotonic_ns()
        self._twist = stepper.twist(step)
        age = self._fixes.age(start)
        if now - start < self._clock.period and age is not None and age <= self._pose_age:
            gate.send(Command(tick, start, *self._twist, self._heard_at))
        if log is not None:
            beacons = [messages.encode_beacon(beacon) for beacon in step.heard]
            log.tick(tick, messages.encode_observation(step.observation), beacons, step.beacon, step.command, now)

    def _send(self, beacon: bytes, radio: Radio) -> None:
        """Send a beacon; one with too many links for a datagram is not sent, and said once."""
        try:
            radio.send(beacon)
        except MessageError as error:
            if not self._unsent:
                self.logger.warning("beacons are not sent: %s", error)
            self._unsent += 1

    def _report(self, tick: int, step: Step | None) -> None:
        """Publish a report if it is due, also of a robot that does not take part."""
        now = time.monotonic_ns()
        if now - self._reported_at >= reports.PERIOD:
            self._reported_at = now
            pose = self._fixes.newest
            report = self._reporter.report(tick, step, pose, now - self._born, self._fixes.age(now), self._progress)
            self._publish(encode_robot_report(report))


def summary(robot: Robot, radio: Radio) -> str:
    """The counts of a robot's run, in one line."""
    counters = radio.counters
    parts = [f"{counters.sent} beacons sent, {counters.heard} heard"]
    if refused := sum(counters.refused.values()):
        rule = max(counters.refused, key=lambda name: counters.refused[name])
        parts.append(f"{refused} refused (most: {rule})")
    if robot.skipped:
        parts.append(f"{robot.skipped} ticks skipped")
    return ", ".join(parts)


def checked_id(file: RobotFile) -> int:
    """The robot's id; raises FesError if the file and the flags give none."""
    if file.id is None:
        raise FesError("expects the id of the robot: --id I, or `id` in the file")
    return file.id
