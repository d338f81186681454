"""RobotReports of a real robot, for observers."""

import numpy as np

from fes.arrays.types import Ints
from fes.model.seeking import MeasuredConfig, SeekingConfig
from fes.protocol import messages
from fes.protocol.messages import Beacon, Command
from fes.protocol.robot_report import NO_AGE, Heard, RobotReport
from field.gate.link import Progress
from field.runtime.fixes import Place
from field.runtime.stepper import Step
from field.senses.senses import Senses

PERIOD = 100_000_000
"""Time between two reports [ns]."""


_NO_PEERS, _NO_NUMBERS = np.zeros(0, dtype=np.int64), np.zeros(0)


class Reporter:
    """Builds the reports of one robot."""

    def __init__(self, robot: int, boot: int, dt: float, seeking: SeekingConfig, senses: Senses) -> None:
        """`boot` is the number of this start of the robot, `dt` the tick length [s]."""
        self._robot, self._boot, self._dt, self._senses = robot, boot, dt, senses
        self._reference = seeking.reference_separation if isinstance(seeking, MeasuredConfig) else 0.0

    def report(
        self,
        tick: int,
        step: Step | None,
        pose: Place | None,
        elapsed: int,
        pose_age: int | None,
        gate: Progress | None,
    ) -> RobotReport:
        """The report at a tick, `elapsed` [ns] after the start; without a `step` the robot does not take part.

        `pose` is the newest one of the body, and `pose_age` its age [ns]; None before the first.
        """
        belief = pose or (0.0, 0.0, 0.0)
        command = Command(tick, self._robot, (0.0, 0.0), _NO_PEERS, _NO_NUMBERS, _NO_NUMBERS)
        if step is not None:
            belief, command = messages.decode_beacon(step.beacon).pose, messages.decode_command(step.command)
        return RobotReport(
            boot=self._boot,
            elapsed=1e-9 * elapsed,
            dt=self._dt,
            pose=belief,
            pose_age=NO_AGE if pose_age is None else 1e-9 * pose_age,
            command=command,
            reference_separation=self._reference,
            beacons=self._heard([] if step is None else step.heard),
            mode="" if gate is None else gate.mode,
            reason="" if gate is None else gate.reason,
        )

    def _heard(self, beacons: list[Beacon]) -> Heard:
        """The counts of each peer, and its estimate of the link to this robot in the last `beacons`."""
        counted, robot = self._senses.counts, self._robot
        peers = sorted(counted)
        last = {beacon.robot: beacon for beacon in beacons}
        estimates = np.full(len(peers), np.nan)
        for place, peer in enumerate(peers):
            if peer in last:
                own = last[peer].estimates[last[peer].links == robot]
                estimates[place] = own[0] if len(own) else np.nan

        def counts(name: str) -> Ints:
            return np.array([getattr(counted[peer], name) for peer in peers], dtype=np.int64)

        ids = np.array(peers, dtype=np.int64)
        return Heard(ids, counts("heard"), counts("missed"), counts("concealed"), estimates)
