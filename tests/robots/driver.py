"""A robot's driver as an ordinary node of ROS 2: `python -m tests.robots.driver ROBOT TWIST POSE`.

It moves as the last twist on /ROBOT/cmd_vel says, and publishes its pose on /ROBOT/odom at 50 Hz. It holds the last
twist for ever, as many drivers do. On standard output it tells, a line of JSON each: the hashes of both types once
both topics are matched, every twist that it hears, and every pose that it publishes. It ends with its standard input.
"""

import json
import math
import os
import sys
import threading
from contextlib import suppress
from typing import Any

import rclpy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException

DT = 0.02  # s
DEPTH = 10
FRAME = "map"

TWISTS = {"Twist": Twist, "TwistStamped": TwistStamped}
POSES = {
    "Odometry": Odometry,
    "PoseStamped": PoseStamped,
    "PoseWithCovarianceStamped": PoseWithCovarianceStamped,
}


def tell(**fields: Any) -> None:
    """One line for the process that has started this one."""
    print(json.dumps(fields), flush=True)


def spin(node: Any) -> None:
    """Let a node work until the standard input is closed, or a signal ends ROS 2; then end the node."""
    ended = threading.Event()

    def read() -> None:
        sys.stdin.read()
        ended.set()

    threading.Thread(target=read, daemon=True).start()
    with suppress(ExternalShutdownException, KeyboardInterrupt):
        while not ended.is_set():
            rclpy.spin_once(node, timeout_sec=0.1)
        node.destroy_node()
        rclpy.shutdown()


class Driver:
    """A unicycle at the origin, and its node."""

    def __init__(self, robot: str, twist: str, pose: str) -> None:
        self.node = rclpy.create_node("driver", namespace=f"/{robot}")
        self.topics = f"/{robot}/cmd_vel", f"/{robot}/odom"
        self.is_matched = False
        self.twist = (0.0, 0.0)
        self.x = self.y = self.heading = 0.0
        self.kind = POSES[pose]
        self.publisher = self.node.create_publisher(self.kind, "odom", DEPTH)
        self.held = [
            self.node.create_subscription(TWISTS[twist], "cmd_vel", self.hear, DEPTH),
            self.node.create_timer(DT, self.step),
        ]

    def hear(self, message: Any) -> None:
        """Take a twist."""
        header = getattr(message, "header", None)
        body = message if header is None else message.twist
        self.twist = body.linear.x, body.angular.z
        stamp = [] if header is None else [header.stamp.sec * 10**9 + header.stamp.nanosec, header.frame_id]
        tell(heard=[*self.twist, *stamp])

    def step(self) -> None:
        """Move for DT, and publish the pose."""
        linear, angular = self.twist
        self.x += DT * linear * math.cos(self.heading)
        self.y += DT * linear * math.sin(self.heading)
        self.heading = math.remainder(self.heading + DT * angular, 2 * math.pi)
        message = self.kind()
        stamp = self.node.get_clock().now()
        message.header.stamp, message.header.frame_id = stamp.to_msg(), FRAME
        place = message.pose if isinstance(message, PoseStamped) else message.pose.pose
        place.position.x, place.position.y = self.x, self.y
        place.orientation.z, place.orientation.w = math.sin(self.heading / 2), math.cos(self.heading / 2)
        if isinstance(message, Odometry):
            message.child_frame_id = "base_link"
            message.twist.twist.linear.x, message.twist.twist.angular.z = linear, angular
        self.publisher.publish(message)
        tell(published=[stamp.nanoseconds, self.x, self.y, self.heading, linear, angular])
        self.match()

    def match(self) -> None:
        """Tell the hashes of both types, as the graph has them, once the other ends are there."""
        heard = self.node.get_publishers_info_by_topic(self.topics[0]) if not self.is_matched else []
        taken = self.node.get_subscriptions_info_by_topic(self.topics[1]) if heard else []
        if taken:
            self.is_matched = True
            tell(matched=[str(ends[0].topic_type_hash) for ends in (heard, taken)])


def main() -> None:
    """Drive until the standard input is closed."""
    rclpy.init()
    driver = Driver(*sys.argv[1:])
    spin(driver.node)
    os._exit(0)  # the thread that reads standard input holds its lock


if __name__ == "__main__":
    main()
