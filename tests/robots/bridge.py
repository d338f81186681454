"""The job of zenoh-bridge-ros2dds for two topics: `python -m tests.robots.bridge ENDPOINT ROBOT TWIST POSE`.

Raw bytes pass from Zenoh to DDS and back. It has no codec of its own that could repair them.
It ends with its standard input.
"""

import json
import os
import sys

import rclpy
import zenoh
import zenoh.handlers

from tests.robots.driver import DEPTH, POSES, TWISTS, spin

SETTINGS = {"mode": "client", "scouting/multicast/enabled": False, "connect/timeout_ms": 10_000}


def main() -> None:
    """Pass messages on until the standard input is closed."""
    endpoint, robot, twist, pose = sys.argv[1:]
    config = zenoh.Config()
    for key, value in {**SETTINGS, "connect/endpoints": [endpoint]}.items():
        config.insert_json5(key, json.dumps(value))
    rclpy.init()
    node = rclpy.create_node("bridge", namespace=f"/{robot}")
    with zenoh.open(config) as session:
        publisher = node.create_publisher(TWISTS[twist], "cmd_vel", DEPTH)
        # as the real bridge puts the samples of reliable writers
        out = session.declare_publisher(f"{robot}/odom", congestion_control=zenoh.CongestionControl.BLOCK)

        def on_command(sample: zenoh.Sample) -> None:
            publisher.publish(sample.payload.to_bytes())

        held = [
            session.declare_subscriber(f"{robot}/cmd_vel", zenoh.handlers.Callback(on_command, indirect=True)),
            node.create_subscription(POSES[pose], "odom", out.put, DEPTH, raw=True),
        ]
        spin(node)
        held.clear()
    os._exit(0)  # the thread that reads standard input holds its lock


if __name__ == "__main__":
    main()
