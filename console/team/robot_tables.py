"""The file robot.toml of a team on a table, from its scenario."""

from typing import Any

from fes.errors import FesError
from world.config.scenario import Scenario, agent_config

ACCELERATION, TURN = 1.0, 40.0
"""Largest changes of speed of a small robot [m/s^2, rad/s^2]; its motors can follow larger ones."""

JUMP = 0.02
"""Error of a pose that does not stop a robot on a table [m]."""

TIMES = {"command_timeout": 0.5, "command_age": 0.4, "pose_age": 0.5, "lateness": 0.3, "motion_check": 4.0}
"""Times of the gates [s], longer than the usual ones: ten robots, their gates and their bodies share one machine."""


def robot_tables(scenario: Scenario, run: str, endpoint: str, radio: str) -> dict[str, Any]:
    """The tables of the file: the laws of `scenario`, for its bodies on the router `endpoint` and the relay `radio`.

    Raises FesError for a scenario without [tabletop].
    """
    table = scenario.tabletop
    if table is None:
        raise FesError("fes team run needs a scenario with the table [tabletop]")
    config = agent_config(scenario)
    laws = config.model_dump(
        mode="json",
        by_alias=True,
        exclude_none=True,
        include={"objective", "seeking", "formation", "localization", "controller"},
    )
    return {
        "schema": 1,
        "run": run,
        "dt": config.dt,
        "seed": config.seed,
        **laws,
        "sensing": config.sensors.model_dump(mode="json"),
        "body": {
            "style": table.style,
            "endpoint": endpoint,
            "domain": table.domain,
            "pose": {"topic": table.pose_topic, "type": table.pose_type, "frame": table.frame},
            "command": {"topic": table.command_topic, "type": table.command_type},
            "scale": table.scale,
        },
        "limits": {
            "linear": table.linear_limit,
            "angular": table.angular_limit,
            "linear_acceleration": ACCELERATION,
            "angular_acceleration": TURN,
            "pose_jump": JUMP,
            **TIMES,
        },
        "radio": {"relay": radio},
        "team": {"endpoint": endpoint},
    }
