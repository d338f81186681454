"""RobotReports of a real robot, for observers."""

import numpy as np

from fes.arrays.types import Ints
from fes.model.seeking import MeasuredConfig, SeekingConfig
from fes.protocol import messages
from fes.protocol.robot_report import NO_AGE, Heard, RobotReport
from field.gate.link import Progress
from field.runtime.stepper import Step
from field.senses.senses import Senses

PERIOD = 100_000_000
"""Time between two reports [ns]."""


class Reporter:
    """Builds the reports of one robot."""

    def __init__(self, boot: int, dt: float, seeking: SeekingConfig, senses: Senses) -> None:
        """`boot` is the number of this start of the robot, `dt` the tick length [s]."""
        self._boot, self._dt, self._senses = boot, dt, senses
        self._reference = seeking.reference_separation if isinstance(seeking, MeasuredConfig) else 0.0

    def report(self, step: Step, elapsed: int, pose_age: int | None, gate: Progress | None) -> RobotReport:
        """The report after a step, `elapsed` [ns] after the start; `pose_age` [ns] is that of the newest pose."""
        beacon = messages.decode_beacon(step.beacon)
        return RobotReport(
            boot=self._boot,
            elapsed=1e-9 * elapsed,
            dt=self._dt,
            pose=beacon.pose,
            pose_age=NO_AGE if pose_age is None else 1e-9 * pose_age,
            command=messages.decode_command(step.command),
            reference_separation=self._reference,
            beacons=self._heard(step),
            mode="" if gate is None else gate.mode,
            reason="" if gate is None else gate.reason,
        )

    def _heard(self, step: Step) -> Heard:
        """The counts of each peer, and its last estimate of the link to this robot."""
        counted, robot = self._senses.counts, step.observation.robot
        peers = sorted(counted)
        last = {beacon.robot: beacon for beacon in step.heard}
        estimates = np.full(len(peers), np.nan)
        for place, peer in enumerate(peers):
            if peer in last:
                own = last[peer].estimates[last[peer].links == robot]
                estimates[place] = own[0] if len(own) else np.nan

        def counts(name: str) -> Ints:
            return np.array([getattr(counted[peer], name) for peer in peers], dtype=np.int64)

        ids = np.array(peers, dtype=np.int64)
        return Heard(ids, counts("heard"), counts("missed"), counts("late"), estimates)
