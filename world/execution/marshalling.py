"""Conversion between the world's arrays and the messages on the bus, one per robot."""

from collections.abc import Iterable, Sequence

import numpy as np

from fes.arrays.edges import Stack
from fes.arrays.types import Bools, Floats, Ints
from fes.errors import MessageError
from fes.model.sensing import Observations, Telemetry
from fes.protocol import keys, messages, packing, wire
from fes.protocol.messages import Command, Observation


def observations(sensed: Observations, present: Bools, since: Ints) -> list[bytes]:
    """The payload of the Observation of each robot that is `present` [n], in id order; empty for others.

    `since` [n] is the tick since which each takes part.
    """
    peers, reception = wire.id_bytes(sensed.in_range.peers), sensed.reception.tobytes()
    fixed = ticks(sensed)
    rows = zip(sensed.poses.tolist(), sensed.in_range.spans, present.tolist(), since.tolist(), fixed, strict=True)
    payloads = []
    for robot, (pose, span, addressed, begun, measured) in enumerate(rows):
        payload = b""
        if addressed:
            begin, end = span.start, span.stop
            in_range = peers[4 * begin : 4 * end]
            payload = packing.pack_observation(
                sensed.tick, robot, pose, in_range, reception[begin:end], False, begun, measured
            )
        payloads.append(payload)
    return payloads


def ticks(sensed: Observations) -> list[int]:
    """Tick at which each pose was measured [n]."""
    return [sensed.tick] * len(sensed.poses) if sensed.fixed is None else sensed.fixed.tolist()


def farewells(sensed: Observations) -> list[bytes]:
    """The payload that tells each robot that the run is over, with its last measured pose."""
    peers = np.zeros(0, dtype=np.int64)
    reception, tick = peers.astype(np.uint8), sensed.tick
    return [
        messages.encode_observation(Observation(tick, robot, tuple(pose), peers, reception, True, 0, fixed))
        for robot, (pose, fixed) in enumerate(zip(sensed.poses.tolist(), ticks(sensed), strict=True))
    ]


def decode(key: str, payload: bytes | None, robots: int) -> Command:
    """The Command in a message of a team of `robots`; raises MessageError."""
    if payload is None:
        raise MessageError("Command", "a deletion is not a command")
    command = messages.decode_command(payload)
    if keys.robot_of(key) != command.robot or command.robot >= robots:
        raise MessageError("Command", "came on another robot's key", key)
    if len(command.links) and command.links[-1] >= robots:
        raise MessageError("Command", "has a link to a robot that does not exist", str(command.links[-1]))
    return command


def all_free(stated: Iterable[bool | None]) -> bool | None:
    """False if one is false, None if one is not known, True if all are true.

    >>> all_free([True, None, False]), all_free([True, None]), all_free([True])
    (False, None, True)
    """
    known = set(stated)
    return False if False in known else True if known == {True} else None


_STANDSTILL = Command(0, 0, (0.0, 0.0), np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0))


class CommandBatch:
    """The commands of a tick as arrays; links that did not change stay the same object."""

    def __init__(self, ids: Ints) -> None:
        self._ids = ids
        self._stack = Stack()

    def read(self, received: Sequence[Command | None]) -> tuple[Floats, Telemetry]:
        """The twists [n, 2] in the commands of all robots, in id order, and the telemetry beside them.

        A robot whose command is None stands still and reports no links.
        """
        commands = [_STANDSTILL if command is None else command for command in received]
        links = self._stack.edges(self._ids, [command.links for command in commands])
        estimates = np.concatenate([command.estimates for command in commands])
        twists = np.array([command.twist for command in commands])
        is_free = all_free(command.is_model_free for command in received if command is not None)
        return twists, Telemetry(links, estimates, self._learnt(commands), self._details(commands), is_free)

    def _learnt(self, commands: list[Command]) -> Floats:
        """The numbers learnt [k, l]; none unless all robots with links have learnt equally many per link."""
        rows = {len(command.learnt) // len(command.links) for command in commands if len(command.links)}
        if len(rows) != 1 or rows == {0}:
            return np.empty((0, sum([len(command.links) for command in commands])))
        [k] = rows
        return np.concatenate([command.learnt.reshape(k, -1) for command in commands], axis=1)

    def _details(self, commands: list[Command]) -> Floats:
        """Further numbers [n, j]; NaN for a robot that sent fewer than others."""
        j = max([len(command.details) for command in commands], default=0)
        if not j:
            return np.empty((len(commands), 0))
        rows = [command.details if len(command.details) == j else np.full(j, np.nan) for command in commands]
        return np.array(rows).reshape(len(commands), j)
