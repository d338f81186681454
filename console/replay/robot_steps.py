"""A second execution of a real robot's own code, from the inputs in its log: compared with it to the bit."""

from collections.abc import Callable
from itertools import pairwise
from typing import TypeVar

import numpy as np

from agents.control import crew
from agents.runtime import marshalling
from agents.runtime.crew_run import CrewRun
from agents.runtime.marshalling import MessageAssembler
from console.replay.difference import of_payloads
from console.replay.recorded import Mismatch
from console.replay.robots import stated
from console.terminal import counting
from console.terminal.counting import Watch
from fes.errors import FesError, MessageError
from fes.extension import crew_laws, evidence
from fes.protocol import messages
from fes.protocol.messages import Beacon, Observation
from fes.recording.robot_log.layout import counted
from fes.recording.robot_log.reader import RecordedStep, RobotRecording

T = TypeVar("T", Observation, Beacon)


def rerun(recording: RobotRecording, watch: Watch = counting.ignore) -> int:
    """Execute the robot of a log again; returns the number of steps.

    `watch` is called with the completed steps. Raises Mismatch where a Beacon or Command differs, and FesError where
    a step is missing: the state after it is unknown.
    """
    robot, count = ReplayedRobot(recording), 0
    for step in recording.steps():
        robot.step(step)
        count += 1
        watch(count)
    return count


class ReplayedRobot:
    """A robot that is executed again, step by step; raises FesError for extensions that have changed."""

    def __init__(self, recording: RobotRecording) -> None:
        header = recording.header
        _check_extensions(recording)
        ids = np.array([header.robot], dtype=np.int64)
        self._log, self._robot = recording, header.robot
        self._crew, self._assembler = CrewRun(crew.create(header.config, ids)), MessageAssembler(ids)
        self._since = 0
        self._tick: int | None = None

    def step(self, step: RecordedStep) -> None:
        """Execute a step, and compare its Beacon and Command; raises Mismatch, or FesError."""
        if step.lost:
            raise FesError(self._gap(step))
        sensed = self._decoded(step, messages.decode_observation, step.observation, step.tick)
        self._check(step, sensed.robot == self._robot, f"an Observation of robot {sensed.robot}")
        heard = [self._decoded(step, messages.decode_beacon, payload, step.tick - 1) for payload in step.beacons]
        senders = [beacon.robot for beacon in heard]
        is_ordered = all(first < second for first, second in pairwise(senders))
        self._check(step, is_ordered, f"Beacons of robots {senders}, which are not ascending")
        if sensed.since != self._since:  # it was absent, and started without state
            self._crew.forget(np.array([True]))
            self._since = sensed.since
        observations, beacons = self._assembler.observations([sensed]), self._assembler.beacons(step.tick - 1, heard)
        sent, twists, telemetry = self._crew.step(observations, beacons)
        telemetry = telemetry._replace(is_model_free=stated([step.command]))
        [(_, *computed)] = marshalling.encode_tick(sent, twists, telemetry)
        for message, logged, again in zip(("Beacon", "Command"), (step.beacon, step.command), computed, strict=True):
            if logged != again:
                raise Mismatch(self._log, of_payloads(step.tick, message, self._robot, logged, again))
        self._tick = step.tick

    def _decoded(self, step: RecordedStep, decode: Callable[[bytes], T], payload: bytes, tick: int) -> T:
        """An input of a step, which must be of this tick."""
        try:
            message = decode(payload)
        except MessageError as error:
            raise FesError(f"{self._log.path}: tick {step.tick}: {error}") from None
        self._check(step, message.tick == tick, f"{type(message).__name__} of tick {message.tick}, not of {tick}")
        return message

    def _check(self, step: RecordedStep, holds: bool, what: str) -> None:
        if not holds:
            raise FesError(f"{self._log.path}: tick {step.tick}: robot {self._robot} received {what}")

    def _gap(self, step: RecordedStep) -> str:
        """The line about steps that are not in the log."""
        until = "its state is unknown from its start on"
        if self._tick is not None:
            until = f"robot {self._robot} is the same to the bit up to tick {self._tick}, then its state is unknown"
        return f"{self._log.path} lacks {counted(step.lost)} before tick {step.tick}: {until}"


def _check_extensions(recording: RobotRecording) -> None:
    """Raise FesError in one line unless the extensions of the robot are those of its log."""
    recorded = {(entry.get("kind"), entry.get("name")): entry for entry in recording.header.extensions}
    for now in crew_laws.evidence_of(recording.header.config):
        known = recorded.get((now.kind, now.name))
        difference = evidence.difference(known, now) if known else f"{now.kind} '{now.name}' was not recorded"
        if difference:
            raise FesError(f"{recording.path}: {difference}")
