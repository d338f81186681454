"""Poses and twists from and to the payloads of five ROS 2 messages.

A robot's driver publishes its pose as Odometry, PoseStamped or PoseWithCovarianceStamped, and takes its twist as
Twist or TwistStamped. Covariances are not looked at: drivers fill them with zeros, -1 or NaN.
"""

import math
from typing import NamedTuple

from fes.errors import MessageError
from fes.ros.cdr import Reader, Writer

POSE_KINDS = ("Odometry", "PoseStamped", "PoseWithCovarianceStamped")
TWIST_KINDS = ("Twist", "TwistStamped")

SECOND = 1_000_000_000
"""[ns]"""

UNIT_TOLERANCE = 0.01
"""Largest difference of a quaternion's squared length from 1; that of tf2."""

LEAST_LEVEL = 0.01
"""Least length of the forward axis in the plane; below it, the robot points up or down and has no heading."""

COVARIANCE = 36
"""Numbers of a covariance."""


class PoseMessage(NamedTuple):
    """The pose of a body, as its driver reports it."""

    stamp: int
    """Time of the pose on the driver's clock [ns]; drivers without a clock write 0."""
    frame: str
    """Name of the frame of the pose."""
    x: float
    """[m; frame]"""
    y: float
    """[m; frame]"""
    heading: float
    """[rad; frame], from -pi to pi"""
    twist: tuple[float, float] | None = None
    """Linear and angular velocity [m/s, rad/s; body] if the message has one: only Odometry."""


def read_pose(kind: str, payload: bytes) -> PoseMessage:
    """The pose in a payload of a message of POSE_KINDS; raises MessageError for any other bytes.

    Every number of pose and twist must be finite, and the quaternion of length 1 within UNIT_TOLERANCE.
    """
    _check_kind(kind, POSE_KINDS)
    reader = Reader(kind, payload)
    stamp, frame = _read_header(reader)
    if kind == "Odometry":
        reader.text()  # the frame of the twist: that of the body
    x, y, _, *quaternion = _finite(reader, reader.doubles(7))
    heading = _heading(reader, *quaternion)
    twist = None
    if kind != "PoseStamped":
        reader.skip_doubles(COVARIANCE)
    if kind == "Odometry":
        linear, _, _, _, _, angular = _finite(reader, reader.doubles(6))
        twist = linear, angular
        reader.skip_doubles(COVARIANCE)
    reader.end()
    return PoseMessage(stamp, frame, x, y, heading, twist)


def write_pose(kind: str, message: PoseMessage) -> bytes:
    """The payload of a message of POSE_KINDS; raises MessageError for numbers that are not finite.

    Covariances are zeros: unknown. Odometry without a twist has zeros, and its child frame is base_link.
    """
    _check_kind(kind, POSE_KINDS)
    linear, angular = message.twist or (0.0, 0.0)
    _check_finite(kind, (message.x, message.y, message.heading, linear, angular))
    writer = Writer(kind)
    _write_header(writer, message.stamp, message.frame)
    if kind == "Odometry":
        writer.text("base_link")
    half = message.heading / 2
    writer.doubles(message.x, message.y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half))
    if kind != "PoseStamped":
        writer.doubles(*[0.0] * COVARIANCE)
    if kind == "Odometry":
        writer.doubles(linear, 0.0, 0.0, 0.0, 0.0, angular, *[0.0] * COVARIANCE)
    return writer.payload()


def read_twist(kind: str, payload: bytes) -> tuple[float, float]:
    """Linear and angular velocity [m/s, rad/s; body] in a payload of a message of TWIST_KINDS; raises MessageError.

    All six numbers must be finite; those of a body that moves sideways or upwards are ignored.
    """
    _check_kind(kind, TWIST_KINDS)
    reader = Reader(kind, payload)
    if kind == "TwistStamped":
        _read_header(reader)
    linear, _, _, _, _, angular = _finite(reader, reader.doubles(6))
    reader.end()
    return linear, angular


def write_twist(kind: str, linear: float, angular: float, stamp: int = 0, frame: str = "") -> bytes:
    """The payload of a message of TWIST_KINDS, from velocities [m/s, rad/s; body] and a time [ns].

    Raises MessageError for numbers that are not finite. Only TwistStamped has the time and the frame.
    """
    _check_kind(kind, TWIST_KINDS)
    _check_finite(kind, (linear, angular))
    writer = Writer(kind)
    if kind == "TwistStamped":
        _write_header(writer, stamp, frame)
    writer.doubles(linear, 0.0, 0.0, 0.0, 0.0, angular)
    return writer.payload()


def _read_header(reader: Reader) -> tuple[int, str]:
    """The time [ns] and the frame of std_msgs/Header."""
    seconds, rest = reader.int32(), reader.uint32()
    if seconds < 0 or rest >= SECOND:
        raise reader.error("a stamp is from 0 s, with less than 10^9 ns, got", f"{seconds} s, {rest} ns")
    return seconds * SECOND + rest, reader.text()


def _write_header(writer: Writer, stamp: int, frame: str) -> None:
    seconds, rest = divmod(stamp, SECOND)
    if seconds < 0:
        raise writer.error("a stamp is from 0 ns, got", stamp)
    writer.int32(seconds)
    writer.uint32(rest)
    writer.text(frame)


def _heading(reader: Reader, x: float, y: float, z: float, w: float) -> float:
    """Direction in the plane of the body's forward axis [rad]; the length of the quaternion cancels out."""
    square = x * x + y * y + z * z + w * w
    if not abs(square - 1.0) <= UNIT_TOLERANCE:
        raise reader.error("expects a quaternion of length 1, got the square", f"{square:.6g}")
    along, across = w * w + x * x - y * y - z * z, 2.0 * (w * z + x * y)
    if math.hypot(along, across) < LEAST_LEVEL:
        shown = f"{x:.6g} {y:.6g} {z:.6g} {w:.6g}"
        raise reader.error("a robot that points up or down has no heading, got", shown)
    return math.atan2(across, along)


def _finite(reader: Reader, values: tuple[float, ...]) -> tuple[float, ...]:
    for value in values:
        if not math.isfinite(value):
            raise reader.error("expects a finite number, got", value)
    return values


def _check_finite(kind: str, values: tuple[float, ...]) -> None:
    for value in values:
        if not math.isfinite(value):
            raise MessageError(kind, "expects a finite number, got", str(value))


def _check_kind(kind: str, kinds: tuple[str, ...]) -> None:
    if kind not in kinds:
        raise MessageError(kind, f"expects one of {', '.join(kinds)}")
