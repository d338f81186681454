"""Between the world's arrays and the messages that cross the bus, one a robot."""

import numpy as np

from fes import messages
from fes.arrays import Floats, Ints
from fes.edges import Stack
from fes.messages import Command, Observation
from fes.sensing import Observations, Telemetry


def observations(sensed: Observations) -> list[bytes]:
    """The payload of each robot's Observation, in id order."""
    rows = zip(sensed.poses.tolist(), sensed.in_range.spans, strict=True)
    return [
        messages.encode_observation(
            Observation(
                sensed.tick,
                robot,
                tuple(pose),
                sensed.in_range.peers[span],
                sensed.reception[span],
                over=False,
            )
        )
        for robot, (pose, span) in enumerate(rows)
    ]


class Told:
    """The commands of a tick as arrays; links that did not change stay the same object."""

    def __init__(self, ids: Ints) -> None:
        self._ids = ids
        self._stack = Stack()

    def read(self, commands: list[Command]) -> tuple[Floats, Telemetry]:
        """The twists [n, 2] in the commands of all robots, in id order, and the telemetry beside them."""
        links = self._stack.edges(self._ids, [command.links for command in commands])
        estimates = np.concatenate([command.estimates for command in commands])
        learnt = np.zeros((2, 0))
        if len(estimates) and all(len(command.learnt) == 2 * len(command.links) for command in commands):
            learnt = np.concatenate([command.learnt.reshape(2, -1) for command in commands], axis=1)
        return np.array([command.twist for command in commands]), Telemetry(links, estimates, learnt)
