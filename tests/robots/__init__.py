"""Real ROS 2 as a witness: an ordinary node of rclpy is driven with the bytes and keys of `fes.ros`.

`tests/robots/run` makes the environment. `driver` and `bridge` are programs of rclpy that know nothing of `fes`;
`stage` starts them beside a Zenoh router, `drive` is our side, and `codec` compares messages without a network.
"""
