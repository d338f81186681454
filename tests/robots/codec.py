"""Messages of ROS 2 against `fes.ros`, through the codec of ROS 2 itself and without a network."""

import math
from collections.abc import Iterator
from random import Random
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message

from fes.ros.messages import PoseMessage, read_pose, read_twist, write_pose, write_twist
from tests.robots.driver import POSES, TWISTS

MESSAGES = 200
"""Of each kind."""

FRAMES = ("", "m", "map", "odom", "robot3/odom", "x" * 255)


def claims() -> Iterator[tuple[bool, str]]:
    """Both directions of each kind, and a line that says it."""
    random = Random(1)
    for kind, foreign in TWISTS.items():
        holds = [_twist_holds(kind, foreign, random) for _ in range(MESSAGES)]
        yield all(holds), f"{kind}: ROS 2 reads our bytes, and we read its bytes, to the digit"
    for kind, foreign in POSES.items():
        holds = [_pose_holds(kind, foreign, random) for _ in range(MESSAGES)]
        yield all(holds), f"{kind}: ROS 2 reads our bytes, and we read its bytes, to the digit"


def _twist_holds(kind: str, foreign: Any, random: Random) -> bool:
    linear, angular = random.gauss(0, 1), random.gauss(0, 1e3)
    stamp, frame = random.randrange(2**31 * 10**9), random.choice(FRAMES)
    message = deserialize_message(write_twist(kind, linear, angular, stamp, frame), foreign)
    body = message.twist if kind == "TwistStamped" else message
    is_equal = (body.linear.x, body.angular.z, body.linear.y, body.angular.x) == (linear, angular, 0.0, 0.0)
    if kind == "TwistStamped":
        is_equal = is_equal and _header(message) == (stamp, frame)
    return is_equal and read_twist(kind, serialize_message(message)) == (linear, angular)


def _pose_holds(kind: str, foreign: Any, random: Random) -> bool:
    twist = (random.gauss(0, 1), random.gauss(0, 1)) if kind == "Odometry" else None
    stamp, frame, heading = random.randrange(2**31 * 10**9), random.choice(FRAMES), random.uniform(-3.1, 3.1)
    own = PoseMessage(stamp, frame, random.gauss(0, 1e3), random.gauss(0, 1e3), heading, twist)
    message = deserialize_message(write_pose(kind, own), foreign)
    place = message.pose if isinstance(message, PoseStamped) else message.pose.pose
    is_equal = _header(message) == (stamp, frame) and (place.position.x, place.position.y) == own[2:4]
    if isinstance(message, Odometry):
        body = message.twist.twist
        is_equal = is_equal and (body.linear.x, body.angular.z) == twist
    read = read_pose(kind, serialize_message(message))
    is_turned = math.isclose(read.heading, heading, abs_tol=4e-16, rel_tol=4e-16)  # sin, cos and atan2 round
    return bool(is_equal and is_turned and read._replace(heading=heading) == own)


def _header(message: Any) -> tuple[int, str]:
    stamp = message.header.stamp
    return stamp.sec * 10**9 + stamp.nanosec, message.header.frame_id
