"""Between the world's arrays and the messages that cross the bus, one a robot."""

from collections.abc import Sequence

import numpy as np

from fes.arrays.edges import Stack
from fes.arrays.types import Bools, Floats, Ints
from fes.errors import MessageError
from fes.model.sensing import Observations, Telemetry
from fes.protocol import keys, messages
from fes.protocol.messages import Command, Observation


def observations(sensed: Observations, present: Bools, since: Ints) -> list[bytes]:
    """The payload of the Observation of each robot that is `present` [n], in id order; empty for others.

    `since` [n]: the tick from which on each takes part.
    """
    rows = zip(sensed.poses.tolist(), sensed.in_range.spans, present.tolist(), since.tolist(), strict=True)
    return [
        messages.encode_observation(
            Observation(
                sensed.tick,
                robot,
                tuple(pose),
                sensed.in_range.peers[span],
                sensed.reception[span],
                over=False,
                since=begun,
            )
        )
        if here
        else b""
        for robot, (pose, span, here, begun) in enumerate(rows)
    ]


def farewells(tick: int, poses: Floats) -> list[bytes]:
    """The payload that tells each robot, at `poses` [n, 3], that the run is over."""
    nobody = np.zeros(0, dtype=np.int64)
    nothing = nobody.astype(np.uint8)
    return [
        messages.encode_observation(Observation(tick, robot, tuple(pose), nobody, nothing, over=True, since=0))
        for robot, pose in enumerate(poses.tolist())
    ]


def decode(key: str, payload: bytes | None, robots: int) -> Command:
    """The Command in a message of a team of `robots`; raises MessageError."""
    if payload is None:
        raise MessageError("Command", "a deletion is not a command")
    found = messages.decode_command(payload)
    if keys.robot_of(key) != found.robot or found.robot >= robots:
        raise MessageError("Command", "came on another robot's key", key)
    if len(found.links) and found.links[-1] >= robots:
        raise MessageError("Command", "has a link to a robot that does not exist", str(found.links[-1]))
    return found


_NOTHING = Command(0, 0, (0.0, 0.0), np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0))


class CommandBatch:
    """The commands of a tick as arrays; links that did not change stay the same object."""

    def __init__(self, ids: Ints) -> None:
        self._ids = ids
        self._stack = Stack()

    def read(self, given: Sequence[Command | None]) -> tuple[Floats, Telemetry]:
        """The twists [n, 2] in the commands of all robots, in id order, and the telemetry beside them.

        None is the command of a robot that is not there: it stands still and says nothing.
        """
        commands = [_NOTHING if decode is None else decode for decode in given]
        links = self._stack.edges(self._ids, [decode.links for decode in commands])
        estimates = np.concatenate([decode.estimates for decode in commands])
        learnt = np.zeros((2, 0))
        if len(estimates) and all(len(decode.learnt) == 2 * len(decode.links) for decode in commands):
            learnt = np.concatenate([decode.learnt.reshape(2, -1) for decode in commands], axis=1)
        return np.array([decode.twist for decode in commands]), Telemetry(links, estimates, learnt)
