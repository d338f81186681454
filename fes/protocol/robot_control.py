"""Messages between an operator and the gates of real robots.

A decoder raises MessageError, and nothing else, on any bytes.
"""

from typing import NamedTuple

from fes.protocol import wire

RUNNING, STOPPED, HELD = "running", "stopped", "held"
"""Modes of a gate: it passes commands; it is latched until it is started; it commands zero and resumes by itself."""

MODES = (RUNNING, STOPPED, HELD)

MAX_OPERATOR = 2**62
"""Largest number of an operator in a Permit."""

LONGEST_REASON = 200
"""Longest reason in a GateStatus [characters]."""


class Permit(NamedTuple):
    """The operator's permission to move, renewed several times per second."""

    operator: int
    """A number that the operator's program has drawn, from 0 to MAX_OPERATOR."""
    sequence: int
    """Number of the Permit: a gate accepts only rising ones of one operator."""


class GateStatus(NamedTuple):
    """The state of the gate of one robot."""

    robot: int
    mode: str
    """One of MODES."""
    reason: str
    """Why it is not running, in one line; empty while it is running."""
    pose: tuple[float, float, float]
    """Last pose of the body: x, y, heading [m, m, rad; team frame, full size]; zeros before the first."""
    pose_age: float
    """Age of that pose [s]; -1 before the first."""
    twist: tuple[float, float]
    """The twist that it commands now, linear and angular [m/s, rad/s; full size]."""
    accepted: int
    """Commands of the agent that passed."""
    refused: int
    """Commands of the agent that were old, repeated or not finite."""


def encode_permit(message: Permit) -> bytes:
    """The payload of a Permit."""
    return wire.pack(*message)


def decode_permit(payload: bytes) -> Permit:
    """The Permit in a payload."""
    name = "Permit"
    operator, sequence = wire.unpack(name, payload, 2)
    wire.check(name, type(operator) is int and 0 <= operator <= MAX_OPERATOR, "expects an operator", operator)
    return Permit(operator, wire.tick(name, sequence))


def encode_gate_status(message: GateStatus) -> bytes:
    """The payload of a GateStatus; a longer reason is cut."""
    robot, mode, reason, pose, age, twist, accepted, refused = message
    return wire.pack(robot, mode, reason[:LONGEST_REASON], list(pose), age, list(twist), accepted, refused)


def decode_gate_status(payload: bytes) -> GateStatus:
    """The GateStatus in a payload."""
    name = "GateStatus"
    robot, mode, reason, pose, age, twist, accepted, refused = wire.unpack(name, payload, 8)
    wire.check(name, type(mode) is str and mode in MODES, "expects a mode", mode)
    is_short = type(reason) is str and len(reason) <= LONGEST_REASON and reason.isprintable()
    wire.check(name, is_short, "expects a reason in one line", reason)
    wire.check(name, type(pose) is list and len(pose) == 3, "expects a pose", pose)
    wire.check(name, type(twist) is list and len(twist) == 2, "expects a twist", twist)
    x, y, heading = wire.finite(name, tuple(pose))
    linear, angular = wire.finite(name, tuple(twist))
    [seconds] = wire.finite(name, (age,))
    counts = wire.tick(name, accepted), wire.tick(name, refused)
    return GateStatus(wire.robot_id(name, robot), mode, reason, (x, y, heading), seconds, (linear, angular), *counts)
