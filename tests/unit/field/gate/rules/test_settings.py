"""Settings of a gate: to and from JSON, and the rules that protect it."""

import json
import math
from dataclasses import replace
from typing import Any

import pytest

from fes.errors import FesError
from field.gate.rules.settings import BodySettings, Limits, Placement, Settings, Timing, TopicSettings, from_json

FULL = Settings(
    robot=3,
    run="lab",
    team=("tcp/127.0.0.1:7447", "tls/10.0.0.1:7447"),
    team_security={"transport/link/tls/enable_mtls": True},
    body=BodySettings(
        "tcp/127.0.0.1:7448",
        style="rmw_zenoh",
        domain=7,
        pose=TopicSettings("robot3/pose", "PoseStamped"),
        command=TopicSettings("robot3/cmd_vel", "TwistStamped"),
        frame="mocap",
    ),
    placement=Placement(100.0, 1.0, -2.0, 0.5),
    limits=Limits(0.1, 2.0, 0.4, 10.0, 0.02),
    timing=Timing(silence=2.0, motion_check=None),
    fence=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),
)


def test_settings_survive_json() -> None:
    assert from_json(FULL.to_json()) == FULL
    assert "\n" not in FULL.to_json()


def test_the_defaults_are_those_of_the_study() -> None:
    timing, limits = Timing(), Limits()
    assert (timing.period, timing.timeout, timing.age, timing.pose_age, timing.permit) == (0.02, 0.25, 0.1, 0.2, 1.0)
    assert (limits.linear, limits.angular, limits.acceleration, limits.angular_acceleration) == (0.2, 3.0, 0.5, 20.0)


@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan, None, True, "1"])
@pytest.mark.parametrize("name", ["linear", "angular", "acceleration", "angular_acceleration", "pose_jump"])
def test_a_limit_that_does_not_limit_is_refused(name: str, value: Any) -> None:
    with pytest.raises(FesError, match=f"a gate expects a positive number as '{name}'"):
        replace(FULL, limits=replace(FULL.limits, **{name: value}))


@pytest.mark.parametrize("name", ["period", "timeout", "age", "pose_age", "permit", "lateness", "patience"])
def test_no_time_can_be_absent_or_infinite(name: str) -> None:
    for value in (None, math.inf, 0.0):
        with pytest.raises(FesError, match=name):
            replace(FULL, timing=replace(FULL.timing, **{name: value}))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "changes",
    [
        {"robot": -1},
        {"robot": "3"},
        {"run": "a/b"},
        {"fence": ((0.0, 0.0), (1.0, 1.0))},
        {"fence": ((0.0, 0.0), (1.0, 1.0), (math.nan, 0.0))},
        {"placement": Placement(scale=0.0)},
        {"placement": Placement(x=math.inf)},
        {"body": BodySettings(style="ros3")},  # type: ignore[arg-type]
        {"body": BodySettings(domain=-1)},
        {"body": BodySettings(pose=TopicSettings("odom", "Twist"))},
        {"body": BodySettings(command=TopicSettings("cmd_vel", "Odometry"))},
        {"body": BodySettings(command=TopicSettings("*", "Twist"))},
        {"body": BodySettings("nowhere")},
        {"team": ("tcp/127.0.0.1:0",)},
    ],
)
def test_a_setting_that_cannot_work_is_refused_in_one_line(changes: dict[str, Any]) -> None:
    with pytest.raises(FesError) as error:
        replace(FULL, **changes)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("endpoint", ["tcp/10.0.0.3:7447", "tcp/robot.local:7447", "udp/[fe80::1]:7447"])
def test_a_body_on_another_machine_is_refused_unless_it_is_said_to_be_remote(endpoint: str) -> None:
    with pytest.raises(FesError, match=r"expects body\.endpoint on this machine"):
        replace(FULL, body=BodySettings(endpoint))
    assert replace(FULL, body=BodySettings(endpoint, remote=True)).body.endpoint == endpoint


@pytest.mark.parametrize("endpoint", ["tcp/127.0.0.5:7447", "tcp/localhost:7447", "udp/[::1]:7447", "unixpipe/a"])
def test_a_body_on_this_machine_is_accepted(endpoint: str) -> None:
    assert replace(FULL, body=BodySettings(endpoint)).body.endpoint == endpoint


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{", "null", "{}", FULL.to_json().replace("fence", "fences"), FULL.to_json().replace("0.4", "NaN")],
)
def test_broken_json_is_an_error_in_one_line(text: str) -> None:
    with pytest.raises(FesError) as error:
        from_json(text)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("part", ["body", "limits", "timing", "placement"])
def test_unknown_fields_of_a_part_are_refused(part: str) -> None:
    table = json.loads(FULL.to_json())
    table[part]["surplus"] = 1
    with pytest.raises(FesError, match="surplus"):
        from_json(json.dumps(table))
