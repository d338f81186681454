"""A scenario's tables [robots] and [sensing]: starts and bodies of the robots, and how they sense their poses."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from fes.arithmetic import draws
from fes.arrays.types import Floats
from fes.model import counts
from fes.model.config import LocalizationConfig as LocalizationConfig
from fes.model.config import SensorConfig
from fes.model.table import Choice, NonNegative, Positive, Table
from fes.protocol.keys import MAX_ROBOTS

FARTHEST = 1e12
"""Largest coordinate of a start [m], at which a double still resolves 0.12 mm."""

MAX_TURN = 1e6
"""Largest heading of a start [rad]."""

MAX_LATENCY = 1000
"""Largest latency of a fix [ticks]; robots remember as many of their poses."""

ROUNDING = 1e-6
"""Distance from a whole number that counts as rounding [1]."""


class RobotsConfig(Table):
    """The robots: explicit poses, or a generated grid or line; their bodies."""

    poses: list[Annotated[tuple[float, float, float], Field(strict=False)]] | None = None
    """Initial poses, a list of x, y and heading [m, m, rad; world frame], in the order of the robot ids."""
    kind: Literal["grid", "line"] = "grid"
    """Shape of the generated start."""
    count: int | None = Field(default=None, ge=1, le=MAX_ROBOTS)
    """Number of robots of the generated start; give either `count` or `poses`."""
    spacing: Positive = 78.0
    """Distance between neighbors of the generated start [m]."""
    jitter: NonNegative = 0.0
    """Largest random displacement of a generated position along x and y [m]."""
    dynamics: Choice = "unicycle"
    """Dynamics of the bodies. `unicycle`: they follow their commands exactly, by (5). An extension is named by
    `module:Class`, by the name of an installed one, or as a table with `use` and its parameters."""
    controller: Choice | None = None
    """A whole robot in plain Python, an extension named as for `dynamics`. It replaces seeking and formation law."""
    actuator_lag: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Time constant with which the velocities of a body follow a command, in first order [s]."""
    slip: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Standard deviation of the factor by which each body is faster or slower than its twist [1]; one factor for each
    velocity, constant in a run. Both velocities also err by a random walk of the same number, in m/sqrt(s) and
    rad/sqrt(s)."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if (self.poses is None) == (self.count is None):
            raise ValueError("give either poses or count")
        if self.poses is not None and not 1 <= len(self.poses) <= MAX_ROBOTS:
            raise ValueError(f"poses must list 1 to {MAX_ROBOTS} robots")
        if self.poses is not None:
            _check(np.array(self.poses, dtype=np.float64))
        elif not self._extent <= FARTHEST:
            raise ValueError(
                f"spacing and jitter must keep all robots within {FARTHEST:g} m of the origin, got {self._extent:g} m"
            )
        return self

    @property
    def _extent(self) -> float:
        """Largest coordinate that a generated start can have [m]."""
        return self.spacing * (self.width - 1) + self.jitter

    @property
    def width(self) -> int:
        """Number of robots per row of a generated start."""
        return math.ceil(math.sqrt(self.number)) if self.kind == "grid" else self.number

    @property
    def number(self) -> int:
        """Number of robots."""
        return len(self.poses) if self.poses is not None else self.count or 0


class SensingConfig(Table):
    """Sensing of the robots' own poses; by default each robot knows its true pose at each tick."""

    pose_noise: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Standard deviation of a fix along x and y, white [m]."""
    heading_noise: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Standard deviation of the heading of a fix, white [rad]."""
    pose_drift: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Standard deviation of an error that wanders, along x and y, for each robot its own [m]. The robots are not told
    of it."""
    pose_drift_time: Annotated[float, Field(ge=1e-3, le=1e9)] = 30.0
    """Correlation time of that error [s]."""
    pose_rate: Annotated[float, Field(ge=1e-6, le=1e9)] | None = None
    """Fixes per second of each robot, at most one per tick [1/s]; None: one at each tick. Robots are staggered, and
    hold a fix until the next one."""
    pose_latency: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Age of a fix when it arrives, a whole number of ticks [s]."""

    @property
    def is_exact(self) -> bool:
        """True if each robot knows its true pose at each tick."""
        noise = self.pose_noise, self.heading_noise, self.pose_drift, self.pose_latency
        return self.pose_rate is None and not any(noise)

    def check(self, dt: float) -> None:
        """Raise ValueError in one line unless rate and latency fit into ticks of `dt` [s]."""
        latency = counts.ratio(self.pose_latency, dt)
        if abs(latency - counts.ticks(self.pose_latency, dt)) > ROUNDING or latency > MAX_LATENCY:
            raise ValueError(
                f"sensing.pose_latency must be a whole number of ticks, at most {MAX_LATENCY}, got {latency:g}"
            )
        if self.pose_rate is not None and self.pose_rate * dt > 1.0 + ROUNDING:
            raise ValueError(
                f"sensing.pose_rate must be at most {1.0 / dt:g}, one fix per tick, got {self.pose_rate:g}"
            )


def data_sheet(robots: RobotsConfig, sensing: SensingConfig) -> SensorConfig:
    """The data sheet that the robots are told: neither drift nor slip."""
    return SensorConfig(
        pose_noise=sensing.pose_noise, heading_noise=sensing.heading_noise, actuator_lag=robots.actuator_lag
    )


def poses(robots: RobotsConfig, seed: int) -> Floats:
    """Poses at tick 0 [n, 3] [m, m, rad; world frame]; floats resolve a millimeter at each of them."""
    if robots.poses is not None:
        return np.array(robots.poses, dtype=np.float64)
    n, width = robots.number, robots.width
    ids = np.arange(n)
    stream = draws.key(seed, "initial pose")
    dx, dy, turn = (draws.uniform_pairs(stream, ids, np.full(n, axis)) for axis in range(3))
    x = robots.spacing * (ids % width) + robots.jitter * (2.0 * dx - 1.0)
    y = robots.spacing * (ids // width) + robots.jitter * (2.0 * dy - 1.0)
    generated = np.stack([x, y, 2.0 * math.pi * turn - math.pi], axis=1)
    _check(generated)
    return generated


def _check(poses: Floats) -> None:
    """Raise ValueError in one line unless poses [n, 3] are finite and within the bounds."""
    rules = (
        (slice(2), FARTHEST, f"be finite and within {FARTHEST:g} m of the origin along x and y"),
        (slice(2, 3), MAX_TURN, f"have finite headings within {MAX_TURN:g} rad"),
    )
    for columns, bound, rule in rules:
        values = poses[:, columns]
        outside = values[~(np.abs(values) <= bound)]
        if len(outside):
            raise ValueError(f"poses must {rule}, got {outside[0]:g}")
