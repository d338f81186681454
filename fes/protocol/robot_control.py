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

MAX_CLOCK = 2**62
"""Largest reading of a clock [ns]."""

LONGEST_REASON = 200
"""Longest reason in a GateStatus [characters]."""


class Permit(NamedTuple):
    """The operator's permission to move, renewed several times per second."""

    operator: int
    """A number that the operator's program has drawn, from 0 to MAX_OPERATOR."""
    sequence: int
    """Number of the Permit: a gate accepts only rising ones of one operator."""
    sent_at: int
    """Reading of the operator's clock when the Permit was sent [ns]; the clock starts at any number."""


class Start(NamedTuple):
    """The operator's request to start one robot; a gate refuses it after a second."""

    clock: int
    """Reading of the gate's clock in the GateStatus that the operator has just received [ns]."""


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
    clock: int = 0
    """Reading of the gate's own clock [ns], which starts at a random number: a Start quotes it."""


def encode_permit(message: Permit) -> bytes:
    """The payload of a Permit."""
    return wire.pack(*message)


def decode_permit(payload: bytes) -> Permit:
    """The Permit in a payload."""
    name = "Permit"
    operator, sequence, sent_at = wire.unpack(name, payload, 3)
    wire.check(name, type(operator) is int and 0 <= operator <= MAX_OPERATOR, "expects an operator", operator)
    return Permit(operator, wire.tick(name, sequence), _clock(name, sent_at))


def encode_start(message: Start) -> bytes:
    """The payload of a Start."""
    return wire.pack(message.clock)


def decode_start(payload: bytes) -> Start:
    """The Start in a payload."""
    [clock] = wire.unpack("Start", payload, 1)
    return Start(_clock("Start", clock))


def encode_gate_status(message: GateStatus) -> bytes:
    """The payload of a GateStatus; a longer reason is cut."""
    robot, mode, reason, pose, age, twist, accepted, refused, clock = message
    return wire.pack(robot, mode, reason[:LONGEST_REASON], list(pose), age, list(twist), accepted, refused, clock)


def decode_gate_status(payload: bytes) -> GateStatus:
    """The GateStatus in a payload."""
    name = "GateStatus"
    robot, mode, reason, pose, age, twist, accepted, refused, clock = wire.unpack(name, payload, 9)
    wire.check(name, type(mode) is str and mode in MODES, "expects a mode", mode)
    is_short = type(reason) is str and len(reason) <= LONGEST_REASON and reason.isprintable()
    wire.check(name, is_short, "expects a reason in one line", reason)
    wire.check(name, type(pose) is list and len(pose) == 3, "expects a pose", pose)
    wire.check(name, type(twist) is list and len(twist) == 2, "expects a twist", twist)
    x, y, heading = wire.finite(name, tuple(pose))
    linear, angular = wire.finite(name, tuple(twist))
    [seconds] = wire.finite(name, (age,))
    numbers = wire.tick(name, accepted), wire.tick(name, refused), _clock(name, clock)
    return GateStatus(wire.robot_id(name, robot), mode, reason, (x, y, heading), seconds, (linear, angular), *numbers)


def _clock(name: str, value: object) -> int:
    wire.check(name, type(value) is int and 0 <= value <= MAX_CLOCK, "expects a reading of a clock", value)
    return value  # type: ignore[return-value]
