"""A team of small robots on a table, a scenario's table [tabletop]: bodies, and their vendor's drivers.

Only fes-tabletop reads it. The defaults are those of the Robotarium, whose robots have 11 cm in diameter.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from fes.model import counts
from fes.model.table import Positive, Table

ROBOT = "{robot}"
"""Stands for the robot's id in the name of a topic."""

DRIVER_PERIOD = 0.01
"""Longest period of a driver's loop [s], which takes commands and tells them to the motors."""

MAX_STEPS = 1000
"""Largest number of physics steps between two poses that a driver publishes."""


class TabletopConfig(Table):
    """Bodies of a team on a table, and the drivers that speak for them in ROS 2 messages over Zenoh."""

    scale: Annotated[float, Field(gt=0, le=1e4)] = 100.0
    """Meters of the law per meter of the table [1]."""
    body: Literal["kinematic", "mujoco"] = "kinematic"
    """Bodies. `kinematic`: they follow their commands exactly. `mujoco`: wheels, motors, friction and collisions."""
    physics_step: Annotated[float, Field(ge=5e-4, le=0.02)] = 0.005
    """Step of the bodies [s]."""
    linear_limit: Positive = 0.2
    """Top speed of a body [m/s]."""
    angular_limit: Positive = 3.6
    """Top rate of turn of a body [rad/s]."""
    wheel_radius: Annotated[float, Field(ge=0.005, le=1)] = 0.016
    """Radius of a wheel [m]."""
    track: Annotated[float, Field(ge=0.02, le=4)] = 0.105
    """Distance between the two wheels [m]."""
    body_radius: Annotated[float, Field(ge=0.01, le=4)] = 0.055
    """Radius of a body [m]."""
    mass: Annotated[float, Field(ge=0.01, le=1e3)] = 0.15
    """Mass of a robot [kg]."""
    motor_time_constant: Annotated[float, Field(ge=1e-3, le=1)] = 0.03
    """Time constant with which a motor follows its command [s]."""
    motor_torque: Positive = 0.02
    """Largest torque at a wheel [N m]."""
    style: Literal["ros2dds", "rmw_zenoh"] = "ros2dds"
    """Keys of the drivers: those of zenoh-bridge-ros2dds, or those of rmw_zenoh."""
    domain: Annotated[int, Field(ge=0, le=232)] = 0
    """ROS domain of the keys of rmw_zenoh."""
    pose_topic: str = Field(default="/robot{robot}/odom", min_length=1, max_length=200)
    """Topic of a robot's pose; `{robot}` stands for its id."""
    pose_type: Literal["Odometry", "PoseStamped", "PoseWithCovarianceStamped"] = "Odometry"
    """Type of the messages on it."""
    command_topic: str = Field(default="/robot{robot}/cmd_vel", min_length=1, max_length=200)
    """Topic of a robot's commands; `{robot}` stands for its id."""
    command_type: Literal["Twist", "TwistStamped"] = "Twist"
    """Type of the messages on it: a driver ignores another one."""
    frame: str = Field(default="map", min_length=1, max_length=200)
    """Frame of the poses, common to all robots."""
    pose_rate: Annotated[float, Field(gt=0, le=1000)] = 50.0
    """Rate of the poses of a driver [1/s]; their period is rounded to a whole number of physics steps."""
    driver_timeout: Positive | None = None
    """Time after which a driver without a new command stops its robot [s]. Without one it holds its last command
    forever, as the drivers of many robots do."""

    @field_validator("pose_topic", "command_topic")
    @classmethod
    def _one_topic_per_robot(cls, topic: str) -> str:
        if topic.count(ROBOT) != 1 or set(topic.replace(ROBOT, "")) & set("{} *$#?"):
            raise ValueError(f"a topic contains {ROBOT} once, and none of *, $, #, ? and blanks, got '{topic}'")
        return topic

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if not self.pose_rate * self.physics_step <= 1.0 + 1e-9:
            raise ValueError(f"pose_rate must be at most 1 / physics_step, got {self.pose_rate:g}")
        counts.check("1 / (pose_rate x physics_step)", 1.0 / self.pose_rate, self.physics_step, MAX_STEPS)
        if not self.wheel_radius < self.body_radius >= 0.5 * self.track:
            raise ValueError(
                f"body_radius must exceed wheel_radius and be at least half the track, got {self.body_radius:g}"
            )
        return self

    @property
    def steps_per_pose(self) -> int:
        """Steps of the bodies between two poses of a driver."""
        return counts.ticks_of(1.0 / self.pose_rate, self.physics_step)

    @property
    def steps_per_cycle(self) -> int:
        """Steps of the bodies in a cycle of a driver's loop: at most DRIVER_PERIOD, if it is more than one."""
        return max(
            steps
            for steps in range(1, self.steps_per_pose + 1)
            if self.steps_per_pose % steps == 0 and (steps == 1 or steps * self.physics_step <= DRIVER_PERIOD + 1e-9)
        )

    def pose_topic_of(self, robot: int) -> str:
        """The topic of the poses of a robot."""
        return self.pose_topic.replace(ROBOT, str(robot))

    def command_topic_of(self, robot: int) -> str:
        """The topic of the commands of a robot."""
        return self.command_topic.replace(ROBOT, str(robot))
