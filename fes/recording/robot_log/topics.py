"""The messages of a robot's log, made in the process that writes it: those that are read, and those for viewers."""

import math
from collections.abc import Iterator
from typing import Any

from google.protobuf.message import Message

from fes.errors import MessageError
from fes.protocol import messages
from fes.recording import messages_pb2, viewer_topics
from fes.recording.messages_pb2 import RobotState, RobotStep

VIEW_PERIOD = 100_000_000
"""Shortest time between two messages for viewers [ns]."""


def step(
    tick: int,
    number: int,
    monotonic_ns: int,
    observation: bytes,
    beacons: list[bytes],
    beacon: bytes,
    command: bytes,
    fix: list[Any] | None,
) -> RobotStep:
    """The message of one step; a `fix` is its time stamp [ns], x, y and heading."""
    message = RobotStep(tick=tick, beacons=beacons, number=number, monotonic_ns=monotonic_ns)
    message.observation, message.beacon, message.command = observation, beacon, command
    if fix is not None:
        stamp, x, y, heading = fix
        message.fix.CopyFrom(messages_pb2.Fix(stamp_ns=stamp, x=x, y=y, heading=heading))
    return message


class View:
    """Messages for viewers of one robot, at most ten times per second."""

    def __init__(self) -> None:
        self._due = 0

    def of(self, observation: bytes, command: bytes, time: int) -> Iterator[tuple[str, Message]]:
        """Topic and message at a time [ns], from the payloads of a step; nothing if they cannot be read."""
        if time < self._due:
            return
        try:
            sensed, returned = messages.decode_observation(observation), messages.decode_command(command)
        except MessageError:
            return  # the log still holds the bytes
        self._due = time + VIEW_PERIOD
        (x, y, heading), (linear, angular) = sensed.pose, returned.twist
        yield "/tf", viewer_topics.transform(sensed.robot, sensed.pose, viewer_topics.timestamp(time))
        links = len(returned.links)
        mean = float(returned.estimates.mean()) if links else math.nan
        state = RobotState(
            x=x, y=y, heading=heading, linear=linear, angular=angular, estimate_mean=mean, links=float(links)
        )
        yield f"/robot/{sensed.robot}/state", state
