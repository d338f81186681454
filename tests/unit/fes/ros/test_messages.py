"""Poses and twists in ROS 2 payloads: written and read to the digit, and any other bytes are refused in one line."""

import math
import struct
from random import Random

import pytest
from hypothesis import example as with_example
from hypothesis import given, settings
from hypothesis import strategies as st

from fes.errors import MessageError
from fes.ros.messages import POSE_KINDS, TWIST_KINDS, PoseMessage, read_pose, read_twist, write_pose, write_twist
from tests.support.examples import EXAMPLES
from tests.support.mutations import mutate
from tests.support.ros_messages import FRAMES, KINDS, NUMBERS, POSES, STAMPS, example, read

HEAD = b"\x00\x01\x00\x00"
POSE_AT = {"Odometry": 36, "PoseStamped": 20, "PoseWithCovarianceStamped": 20}
"""First byte of the pose, behind the frames map and base_link."""


def turned(kind: str, *quaternion: float) -> bytes:
    """An example of a kind with another quaternion (x, y, z, w)."""
    payload, start = example(kind), POSE_AT[kind] + 24
    return payload[:start] + struct.pack("<4d", *quaternion) + payload[start + 32 :]


def test_a_twist_is_its_encapsulation_and_six_doubles() -> None:
    assert write_twist("Twist", 0.5, -0.25) == HEAD + struct.pack("<6d", 0.5, 0, 0, 0, 0, -0.25)


def test_a_stamped_twist_has_its_time_its_frame_and_zeros_as_padding() -> None:
    header = struct.pack("<iII", 7, 5, 10) + b"base_link\0" + bytes(2)
    expected = HEAD + header + struct.pack("<6d", 0.5, 0, 0, 0, 0, -0.25)
    assert write_twist("TwistStamped", 0.5, -0.25, 7_000_000_005, "base_link") == expected


@pytest.mark.parametrize(
    ("kind", "doubles"), [("Odometry", 85), ("PoseStamped", 7), ("PoseWithCovarianceStamped", 43)]
)
def test_a_pose_has_the_numbers_of_its_definition_at_its_end(kind: str, doubles: int) -> None:
    payload = write_pose(kind, PoseMessage(0, "odom", 1.0, 2.0, 0.5, None))
    start = len(payload) - 8 * doubles
    assert start == (44 if kind == "Odometry" else 28)  # 724 bytes of Odometry were counted from a real node
    assert struct.unpack_from("<7d", payload, start) == (1.0, 2.0, 0, 0, 0, math.sin(0.25), math.cos(0.25))


@pytest.mark.parametrize("kind", POSE_KINDS)
@settings(max_examples=EXAMPLES)
@given(message=POSES)
def test_a_pose_is_read_as_it_was_written(kind: str, message: PoseMessage) -> None:
    back = read_pose(kind, write_pose(kind, message))
    assert back[:4] == message[:4]
    # sin, cos and atan2 round once each, near 1
    assert math.isclose(back.heading, message.heading, abs_tol=4e-16, rel_tol=4e-16)
    assert back.twist == ((message.twist or (0.0, 0.0)) if kind == "Odometry" else None)


@pytest.mark.parametrize("kind", TWIST_KINDS)
@settings(max_examples=EXAMPLES)
@given(linear=NUMBERS, angular=NUMBERS, stamp=STAMPS, frame=FRAMES)
def test_a_twist_is_read_as_it_was_written(kind: str, linear: float, angular: float, stamp: int, frame: str) -> None:
    assert read_twist(kind, write_twist(kind, linear, angular, stamp, frame)) == (linear, angular)


@pytest.mark.parametrize("written", KINDS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("frame", ["", "map", "a/frame/of/thirty-one/characters", "x" * 255])
def test_a_payload_of_another_kind_is_refused(written: str, kind: str, frame: str) -> None:
    payload = example(written, frame)
    if written == kind:
        assert read(kind, payload)
    else:
        with pytest.raises(MessageError):
            read(kind, payload)


@pytest.mark.parametrize("kind", KINDS)
def test_a_payload_that_is_cut_or_longer_is_refused(kind: str) -> None:
    payload = example(kind)
    for length in range(len(payload)):
        with pytest.raises(MessageError):
            read(kind, payload[:length])
    for count in range(1, 20):
        with pytest.raises(MessageError, match="bytes, got"):
            read(kind, payload + bytes(count))


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=3 * EXAMPLES)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_mutated_payload_gives_finite_numbers_or_a_line(kind: str, seed: int) -> None:
    random = Random(seed)
    for _ in range(5):
        outcome(kind, mutate(random, example(kind), [example(other) for other in KINDS]))


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=3 * EXAMPLES)
@given(bit=st.integers(0, 8 * 724 - 1))
def test_a_payload_with_a_flipped_bit_gives_finite_numbers_or_a_line(kind: str, bit: int) -> None:
    payload = bytearray(example(kind))
    payload[bit // 8 % len(payload)] ^= 1 << bit % 8
    outcome(kind, bytes(payload))


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=EXAMPLES)
@given(body=st.binary(max_size=800), order=st.sampled_from([b"\0\0", b"\0\1", b""]))
@with_example(body=b"\xff" * 800, order=b"\0\1")
def test_any_bytes_give_finite_numbers_or_a_line(kind: str, body: bytes, order: bytes) -> None:
    outcome(kind, order + body)


def outcome(kind: str, payload: bytes) -> None:
    """Read a payload: all numbers that are read are finite, and an error is one printable line."""
    line, numbers = "", list[float]()
    try:
        values = read(kind, payload)
        numbers = [value for part in values for value in (part if isinstance(part, tuple) else (part,))]
    except MessageError as error:
        line = str(error)
    assert bool(line) != bool(numbers)
    assert len(line) < 200
    assert line.isprintable()
    assert all(math.isfinite(number) for number in numbers if isinstance(number, float))


@pytest.mark.parametrize("kind", KINDS)
def test_big_endian_is_read_too(kind: str) -> None:
    payload, body = example(kind, "map", 1_500_000_007), b""
    if kind != "Twist":
        body = struct.pack(">iII", 1, 500_000_007, 4) + b"map\0"
    if kind == "Odometry":
        body += struct.pack(">I", 10) + b"base_link\0" + bytes(2)
    count = (len(payload) - 4 - len(body)) // 8
    values = struct.unpack_from(f"<{count}d", payload, 4 + len(body))
    assert read(kind, b"\0\0\0\0" + body + struct.pack(f">{count}d", *values)) == read(kind, payload)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_number_of_pose_or_twist_that_is_not_finite_is_refused(kind: str, bad: float) -> None:
    payload = example(kind)
    groups = {"Twist": [(4, 6)], "TwistStamped": [(len(payload) - 48, 6)]}.get(kind) or [(POSE_AT[kind], 7)]
    if kind == "Odometry":
        groups.append((POSE_AT[kind] + 8 * 43, 6))
    for start, count in groups:
        for number in range(count):
            spot = start + 8 * number
            with pytest.raises(MessageError, match=r"finite|quaternion"):
                read(kind, payload[:spot] + struct.pack("<d", bad) + payload[spot + 8 :])


@pytest.mark.parametrize("kind", ["Odometry", "PoseWithCovarianceStamped"])
def test_a_covariance_of_any_numbers_is_accepted(kind: str) -> None:
    payload = bytearray(example(kind))
    struct.pack_into("<36d", payload, POSE_AT[kind] + 56, *[math.nan] * 36)
    assert read_pose(kind, bytes(payload)) == read_pose(kind, example(kind))


@pytest.mark.parametrize("kind", POSE_KINDS)
def test_the_heading_is_that_of_the_forward_axis_of_a_tilted_body(kind: str) -> None:
    heading, pitch, roll = 2.0, 0.3, -0.4
    cy, sy, cp, sp = math.cos(heading / 2), math.sin(heading / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    # the product of the three turns, about z, y and x
    x, y = sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy
    z, w = cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy
    for sign in (1, -1):  # both quaternions of one rotation
        read_back = read_pose(kind, turned(kind, sign * x, sign * y, sign * z, sign * w))
        assert math.isclose(read_back.heading, heading, rel_tol=1e-14)


@pytest.mark.parametrize("kind", POSE_KINDS)
@pytest.mark.parametrize("length", [0.0, 0.99, 1.01, 2.0, 1e200])
def test_a_quaternion_of_another_length_is_refused(kind: str, length: float) -> None:
    with pytest.raises(MessageError, match="expects a quaternion of length 1"):
        read_pose(kind, turned(kind, 0.0, 0.0, 0.0, length))


@pytest.mark.parametrize("kind", POSE_KINDS)
@pytest.mark.parametrize("length", [0.996, 1.004])
def test_a_rounded_quaternion_is_accepted_and_its_length_does_not_count(kind: str, length: float) -> None:
    read_back = read_pose(kind, turned(kind, 0.0, 0.0, length * math.sin(0.25), length * math.cos(0.25)))
    assert math.isclose(read_back.heading, 0.5, rel_tol=1e-15)


def test_a_robot_that_points_up_has_no_heading() -> None:
    with pytest.raises(MessageError, match="points up or down"):
        read_pose("PoseStamped", turned("PoseStamped", 0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "Twist"])
def test_a_stamp_before_zero_or_with_a_second_of_nanoseconds_is_refused(kind: str) -> None:
    for stamp in (struct.pack("<iI", -1, 0), struct.pack("<iI", 0, 10**9)):
        with pytest.raises(MessageError, match="stamp"):
            read(kind, HEAD + stamp + example(kind)[12:])
    with pytest.raises(MessageError, match="stamp"):
        example(kind, stamp=-1)
    with pytest.raises(MessageError, match="32 bits"):
        example(kind, stamp=2**31 * 10**9)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_number_that_is_not_finite_is_not_written(bad: float) -> None:
    for kind in TWIST_KINDS:
        for twist in ((bad, 0.0), (0.0, bad)):
            with pytest.raises(MessageError, match="finite"):
                write_twist(kind, *twist)
    for kind in POSE_KINDS:
        for field in ({"x": bad}, {"y": bad}, {"heading": bad}, {"twist": (0.0, bad)}):
            with pytest.raises(MessageError, match="finite"):
                write_pose(kind, PoseMessage(0, "", 0.0, 0.0, 0.0)._replace(**field))


def test_a_kind_of_the_other_family_is_refused() -> None:
    with pytest.raises(MessageError, match="Twist: expects one of Odometry"):
        read_pose("Twist", example("Twist"))
    with pytest.raises(MessageError, match="Odometry: expects one of Twist"):
        read_twist("Odometry", example("Odometry"))
    with pytest.raises(MessageError, match="expects one of"):
        write_pose("Pose", PoseMessage(0, "", 0.0, 0.0, 0.0))
    with pytest.raises(MessageError, match="expects one of"):
        write_twist("Bool", 0.0, 0.0)
