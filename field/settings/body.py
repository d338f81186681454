"""The tables [body], [limits] and [team] of robot.toml: driver, frame, gate, and the operator's network.

Lengths and speeds in these tables are those of the body. The law's are `scale` times as large.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from fes.model.table import OwnTable, Positive
from fes.transport.endpoints import DEFAULT_ENDPOINT

Endpoint = Annotated[str, Field(min_length=1, max_length=200)]
TopicName = Annotated[str, Field(min_length=1, max_length=200)]
Coordinate = Annotated[float, Field(ge=-1e7, le=1e7)]
Corner = Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]

ROBOT = "{robot}"
"""Stands for the robot's id in the name of a topic."""


class PoseConfig(OwnTable):
    """The topic on which the robot reports its pose."""

    topic: TopicName = f"robot{ROBOT}/odom"
    """Name of the topic; `{robot}` stands for the robot's id."""
    type: Literal["Odometry", "PoseStamped", "PoseWithCovarianceStamped"] = "Odometry"
    """Type of its messages."""
    frame: TopicName = "map"
    """Required `frame_id` of the poses, the same for the whole team. `odom` rarely suits: each robot has its own."""


class CommandConfig(OwnTable):
    """The topic on which the robot receives its commands."""

    topic: TopicName = f"robot{ROBOT}/cmd_vel"
    """Name of the topic; `{robot}` stands for the robot's id."""
    type: Literal["Twist", "TwistStamped"] = "Twist"
    """Type of its messages. A driver that expects the other type silently ignores them."""


class BodyConfig(OwnTable):
    """The robot's driver, and its place in the team's frame."""

    style: Literal["ros2dds", "rmw_zenoh"] = "ros2dds"
    """Keys of ROS 2 topics: those of zenoh-bridge-ros2dds, or of the middleware rmw_zenoh."""
    endpoint: Endpoint = DEFAULT_ENDPOINT
    """Zenoh endpoint of the bridge, or of the robot's own router. It must be on this machine."""
    domain: Annotated[int, Field(ge=0, le=232)] = 0
    """ROS_DOMAIN_ID, for the style `rmw_zenoh`."""
    pose: PoseConfig = PoseConfig()
    """Topic of the robot's poses."""
    command: CommandConfig = CommandConfig()
    """Topic of the robot's commands."""
    scale: Annotated[float, Field(ge=1e-3, le=1e6)] = 1.0
    """Meters of the law per meter of the body [1]: 100 for a team on a table."""
    x: Coordinate = 0.0
    """x of the origin of the pose frame, in the team's frame [m; body's size]."""
    y: Coordinate = 0.0
    """y of the origin of the pose frame, in the team's frame [m; body's size]."""
    heading: Annotated[float, Field(ge=-7.0, le=7.0)] = 0.0
    """Direction of the frame's x axis in the team's frame [rad]."""


class LimitsConfig(OwnTable):
    """Limits that the gate keeps between the law and the driver."""

    linear: Positive = 0.2
    """Largest linear speed [m/s]."""
    angular: Positive = 3.0
    """Largest angular speed [rad/s]."""
    linear_acceleration: Positive = 0.5
    """Largest change of the linear speed [m/s^2]."""
    angular_acceleration: Positive = 20.0
    """Largest change of the angular speed [rad/s^2]."""
    command_timeout: Positive = 0.25
    """Time without a new command after which the gate commands zero [s]."""
    command_age: Positive = 0.1
    """Largest age of a command; the gate refuses older ones [s]."""
    pose_age: Positive = 0.2
    """Time without a pose after which the gate commands zero [s]."""
    pose_jump: Positive = 0.05
    """A pose that is farther from the last one than the limits allow, by more than this [m], stops the robot."""
    permit_timeout: Positive = 1.0
    """Time without the operator's permit after which the robot stops [s]."""
    silence: Positive | None = None
    """Time without a beacon of any peer after which the gate commands zero [s]; none by default."""
    lateness: Positive = 0.1
    """Largest delay of the gate's own loop; after that it commands zero [s]. On a busy machine .04 is usual."""
    motion_check: Annotated[float, Field(ge=0, le=30)] = 2.0
    """Time over which the gate compares the motion of the pose with the commands [s]; 0 for no check."""
    fence: list[Corner] = Field(default=[], max_length=100)
    """Corners of the area that the robot must not leave [m; team's frame, of the body]; no fence by default."""

    @model_validator(mode="after")
    def _has_area(self) -> Self:
        if 0 < len(self.fence) < 3:
            raise ValueError(f"fence: must have at least 3 corners, got {len(self.fence)}")
        return self


class TeamConfig(OwnTable):
    """The network of the team: permits, stops and reports."""

    endpoint: Endpoint = DEFAULT_ENDPOINT
    """Zenoh endpoint that the operator's laptop uses too."""
