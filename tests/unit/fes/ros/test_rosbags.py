"""Payloads and hashes against those of rosbags, which has its own codec and its own copy of the definitions."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from rosbags.typesys import Stores, get_typestore

from fes.ros.messages import POSE_KINDS, TWIST_KINDS, PoseMessage, read_pose, read_twist, write_pose, write_twist
from fes.ros.types import TYPES
from tests.support.examples import EXAMPLES
from tests.support.ros_messages import FRAMES, NUMBERS, POSES, STAMPS

STORES = [Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED]
STORE: Any = get_typestore(Stores.ROS2_KILTED)
KNOWN = STORE.types


def made(name: str, **fields: Any) -> Any:
    """A message of rosbags."""
    return KNOWN[name](**fields)


def header(stamp: int, frame: str) -> Any:
    time = made("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9)
    return made("std_msgs/msg/Header", stamp=time, frame_id=frame)


def twist(linear: float, angular: float) -> Any:
    vector = "geometry_msgs/msg/Vector3"
    along, about = made(vector, x=linear, y=0.0, z=0.0), made(vector, x=0.0, y=0.0, z=angular)
    return made("geometry_msgs/msg/Twist", linear=along, angular=about)


def pose(message: PoseMessage) -> Any:
    point = made("geometry_msgs/msg/Point", x=message.x, y=message.y, z=0.0)
    half = message.heading / 2
    turn = made("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))
    return made("geometry_msgs/msg/Pose", position=point, orientation=turn)


def foreign_pose(kind: str, message: PoseMessage) -> Any:
    """A pose as a message of rosbags."""
    head, place, unknown = header(message.stamp, message.frame), pose(message), np.zeros(36)
    if kind == "PoseStamped":
        return made("geometry_msgs/msg/PoseStamped", header=head, pose=place)
    estimated = made("geometry_msgs/msg/PoseWithCovariance", pose=place, covariance=unknown)
    if kind == "PoseWithCovarianceStamped":
        return made("geometry_msgs/msg/PoseWithCovarianceStamped", header=head, pose=estimated)
    moving = twist(*(message.twist or (0.0, 0.0)))
    moving = made("geometry_msgs/msg/TwistWithCovariance", twist=moving, covariance=unknown)
    return made("nav_msgs/msg/Odometry", header=head, child_frame_id="base_link", pose=estimated, twist=moving)


@pytest.mark.parametrize("store", STORES, ids=lambda store: store.name)
def test_the_hashes_are_those_of_every_release_from_humble_to_kilted(store: Any) -> None:
    known: Any = get_typestore(store)
    assert {name: known.hash_rihs01(kind.full) for name, kind in TYPES.items()} == {
        name: kind.hash for name, kind in TYPES.items()
    }


@pytest.mark.parametrize("kind", POSE_KINDS)
@settings(max_examples=EXAMPLES)
@given(message=POSES)
def test_the_bytes_of_a_pose_are_those_of_rosbags(kind: str, message: PoseMessage) -> None:
    own = write_pose(kind, message)
    foreign = bytes(STORE.serialize_cdr(foreign_pose(kind, message), TYPES[kind].full))
    assert own == foreign
    big = bytes(STORE.serialize_cdr(foreign_pose(kind, message), TYPES[kind].full, little_endian=False))
    assert read_pose(kind, big) == read_pose(kind, foreign)
    read_back = STORE.deserialize_cdr(own, TYPES[kind].full)
    assert (read_back.header.frame_id, read_back.header.stamp.sec) == (message.frame, message.stamp // 10**9)


@pytest.mark.parametrize("kind", TWIST_KINDS)
@settings(max_examples=EXAMPLES)
@given(linear=NUMBERS, angular=NUMBERS, stamp=STAMPS, frame=FRAMES)
def test_the_bytes_of_a_twist_are_those_of_rosbags(
    kind: str, linear: float, angular: float, stamp: int, frame: str
) -> None:
    foreign = twist(linear, angular)
    if kind == "TwistStamped":
        foreign = made("geometry_msgs/msg/TwistStamped", header=header(stamp, frame), twist=foreign)
    own = write_twist(kind, linear, angular, stamp, frame)
    assert own == bytes(STORE.serialize_cdr(foreign, TYPES[kind].full))
    big = bytes(STORE.serialize_cdr(foreign, TYPES[kind].full, little_endian=False))
    assert read_twist(kind, big) == (linear, angular)
