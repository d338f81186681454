"""Settings of a gate, as its process reads them: plain values and JSON, so that it starts fast.

The agent has checked the file of its robot. The rules here protect the gate itself: a limit that is zero, infinite or
missing would be no limit.
"""

import ipaddress
import math
from dataclasses import asdict, dataclass, field
from typing import Any

from fes.errors import FesError
from fes.protocol import keys
from fes.ros.messages import POSE_KINDS, TWIST_KINDS
from fes.ros.topics import Style, Topic, check_topic
from fes.system import strict_json
from fes.transport import addresses

MOST = 1e6
"""Largest number of a setting, in its own unit."""


@dataclass(frozen=True)
class TopicSettings:
    """A ROS 2 topic."""

    name: str
    """Name of the topic, with its namespace: "robot3/odom"."""
    type: str
    """Type of its messages, a short name of `fes.ros.types`."""


@dataclass(frozen=True)
class BodySettings:
    """The vendor's driver, as it is reached over Zenoh."""

    endpoint: str = "tcp/127.0.0.1:7447"
    """Endpoint of the bridge, or of the router of rmw_zenoh."""
    remote: bool = False
    """True to accept an endpoint on another machine: after a cut, TCP delivers stale commands in a burst."""
    style: Style = "ros2dds"
    """Style of the keys."""
    domain: int = 0
    """ROS_DOMAIN_ID, for the style rmw_zenoh."""
    pose: TopicSettings = TopicSettings("odom", "Odometry")
    command: TopicSettings = TopicSettings("cmd_vel", "Twist")
    frame: str = "map"
    """Frame of the poses; others are refused."""

    @property
    def pose_topic(self) -> Topic:
        """The topic of the poses."""
        return Topic(self.style, self.pose.name, self.pose.type, self.domain)

    @property
    def command_topic(self) -> Topic:
        """The topic of the commands."""
        return Topic(self.style, self.command.name, self.command.type, self.domain)


@dataclass(frozen=True)
class Placement:
    """The body's frame in the team frame, and the scale between body and law."""

    scale: float = 1.0
    """Meters of the law per meter of the body."""
    x: float = 0.0
    y: float = 0.0
    """Origin of the body's frame [m of the body; team frame]."""
    heading: float = 0.0
    """Direction of the body's x axis [rad; team frame]."""


@dataclass(frozen=True)
class Limits:
    """Limits of the commands, in the body's own units."""

    linear: float = 0.2
    """[m/s]"""
    angular: float = 3.0
    """[rad/s]"""
    acceleration: float = 0.5
    """[m/s²]"""
    angular_acceleration: float = 20.0
    """[rad/s²]"""
    pose_jump: float = 0.05
    """Distance that two poses may be further apart than the limits allow [m]."""

    def clipped(self, linear: float, angular: float) -> tuple[float, float]:
        """A twist within the limits of the velocities."""
        return _clipped(linear, -self.linear, self.linear), _clipped(angular, -self.angular, self.angular)

    def approached(self, last: tuple[float, float], wanted: tuple[float, float], dt: float) -> tuple[float, float]:
        """The twist `dt` [s] after the last one, on the way to a wanted one, within the limits of accelerations."""
        linear, angular = self.acceleration * dt, self.angular_acceleration * dt
        return (
            _clipped(wanted[0], last[0] - linear, last[0] + linear),
            _clipped(wanted[1], last[1] - angular, last[1] + angular),
        )


@dataclass(frozen=True)
class Timing:
    """Periods and ages [s]."""

    period: float = 0.02
    """Period of the gate's loop."""
    timeout: float = 0.25
    """Age of the last good command from which on the gate commands zero."""
    age: float = 0.1
    """Largest age of a command that arrives."""
    pose_age: float = 0.2
    """Largest age of the last pose."""
    permit: float = 1.0
    """Largest age of the operator's last Permit."""
    lateness: float = 0.04
    """Tolerated lateness of the gate's loop."""
    silence: float | None = None
    """Time without a beacon of any peer from which on the gate commands zero; None for never."""
    motion_check: float | None = 2.0
    """Time within which the pose must move as commanded; None for no check."""
    patience: float = 30.0
    """Longest wait for the endpoints at the start."""

    @property
    def longest_period(self) -> float:
        """Longest tolerated period of the gate's loop."""
        return self.period + self.lateness


@dataclass(frozen=True)
class Settings:
    """Everything that the gate of one robot needs."""

    robot: int
    run: str = keys.DEFAULT_RUN
    team: tuple[str, ...] = ("tcp/127.0.0.1:7447",)
    """Endpoints through which the operator is reached."""
    team_security: dict[str, Any] = field(default_factory=dict)
    """Settings of Zenoh for the session with the operator, by key, such as those of the certificates."""
    body: BodySettings = BodySettings()
    placement: Placement = Placement()
    limits: Limits = Limits()
    timing: Timing = Timing()
    fence: tuple[tuple[float, float], ...] = ()
    """Corners of the polygon that the robot must not leave [m; team frame, full size]; empty for none."""

    def __post_init__(self) -> None:
        keys.check_run(self.run)
        _check(type(self.robot) is int and 0 <= self.robot < keys.MAX_ROBOTS, "expects the id of a robot", self.robot)
        for topic, kinds in ((self.body.pose_topic, POSE_KINDS), (self.body.command_topic, TWIST_KINDS)):
            check_topic(topic)
            _check(topic.type in kinds, f"expects one of {', '.join(kinds)} as the type of {topic.name}", topic.type)
        _check_numbers(self)
        _check(len(self.fence) not in (1, 2), "expects at least three corners of a fence", self.fence)
        for endpoint in (*self.team, self.body.endpoint):
            addresses.check(endpoint, listening=False)
        is_near = self.body.remote or is_on_this_machine(self.body.endpoint)
        _check(is_near, "expects body.endpoint on this machine, or --remote-body", self.body.endpoint)

    def to_json(self) -> str:
        """The settings in one line of JSON."""
        return strict_json.dumps(asdict(self), refuse=True)


def from_json(text: str | bytes) -> Settings:
    """The settings in a line of JSON; raises FesError for an unknown or missing field, type or number."""
    try:
        table = strict_json.loads(text)
        body = table["body"]
        topics = {name: TopicSettings(**body[name]) for name in ("pose", "command")}
        parts = {
            "team": tuple(table["team"]),
            "body": BodySettings(**{**body, **topics}),
            "placement": Placement(**table["placement"]),
            "limits": Limits(**table["limits"]),
            "timing": Timing(**table["timing"]),
            "fence": tuple((x, y) for x, y in table["fence"]),
        }
        return Settings(**{**table, **parts})
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise FesError(f"the settings of a gate are one table of JSON: {type(error).__name__}: {error}") from None


def is_on_this_machine(endpoint: str) -> bool:
    """True if an endpoint is reached without a network.

    >>> is_on_this_machine("tcp/127.0.0.1:7447"), is_on_this_machine("tcp/10.0.0.3:7447")
    (True, False)
    """
    place = addresses.place(endpoint)
    if place is None:
        return endpoint.startswith("unix")
    try:
        return ipaddress.ip_address(place.host.partition("%")[0]).is_loopback
    except ValueError:
        return place.host == "localhost"


def _check_numbers(settings: Settings) -> None:
    placement, limits, timing = asdict(settings.placement), asdict(settings.limits), asdict(settings.timing)
    positive = {**limits, **timing, "scale": placement.pop("scale")}
    optional = {"silence", "motion_check"}
    for name, value in positive.items():
        is_positive = (value is None and name in optional) or (_is_number(value) and value > 0)
        _check(is_positive, f"expects a positive number as '{name}'", value)
    for name, value in placement.items():
        _check(_is_number(value), f"expects a number as '{name}'", value)
    for corner in settings.fence:
        _check(all(map(_is_number, corner)), "expects numbers as a corner of the fence", corner)


def _is_number(value: object) -> bool:
    return type(value) in (int, float) and math.isfinite(value) and abs(value) <= MOST  # type: ignore[arg-type]


def _clipped(value: float, least: float, most: float) -> float:
    return max(least, min(most, value))


def _check(holds: bool, rule: str, value: object) -> None:
    if not holds:
        raise FesError(f"a gate {rule}, got {str(value)[:80]!r}")
