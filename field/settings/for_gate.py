"""The settings of a robot's gate, from its file."""

from typing import Any

from field.gate.rules.settings import BodySettings, Limits, Placement, Settings, Timing, TopicSettings
from field.settings.body import ROBOT
from field.settings.robot_file import RobotFile


def gate_settings(
    file: RobotFile,
    robot: int,
    *,
    remote: bool = False,
    security: dict[str, Any] | None = None,
    patience: float = 30.0,
) -> Settings:
    """The settings of the gate of `robot`; raises FesError for one that no gate accepts.

    `remote` allows a driver on another machine, `security` holds Zenoh's settings for the operator's network, and
    `patience` is the longest wait for the endpoints [s].
    """
    body, limits = file.body, file.limits
    return Settings(
        robot=robot,
        run=file.run,
        team=(file.team.endpoint,),
        team_security=security or {},
        body=BodySettings(
            endpoint=body.endpoint,
            remote=remote,
            style=body.style,
            domain=body.domain,
            pose=TopicSettings(body.pose.topic.replace(ROBOT, str(robot)), body.pose.type),
            command=TopicSettings(body.command.topic.replace(ROBOT, str(robot)), body.command.type),
            frame=body.pose.frame,
        ),
        placement=Placement(body.scale, body.x, body.y, body.heading),
        limits=Limits(
            limits.linear,
            limits.angular,
            limits.linear_acceleration,
            limits.angular_acceleration,
            limits.pose_jump,
        ),
        timing=Timing(
            timeout=limits.command_timeout,
            age=limits.command_age,
            pose_age=limits.pose_age,
            permit=limits.permit_timeout,
            lateness=limits.lateness,
            silence=limits.silence,
            motion_check=limits.motion_check or None,
            patience=patience,
        ),
        fence=tuple((body.scale * x, body.scale * y) for x, y in limits.fence),
    )
