"""A Run: what happened at every tick, as arrays."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from console.api import columns
from fes.arrays.types import Bools, Floats, Ints
from world.config.scenario import Scenario

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class LinkTable:
    """The links in use: one row per tick, robot and linked peer, in this order; l rows.

    A link has two ends, and each end is a row of its own where that robot uses the link.
    """

    tick: Ints
    """Tick [l]."""
    robot: Ints
    """Id of the robot that uses the link [l]."""
    peer: Ints
    """Id of its peer [l]."""
    separation: Floats
    """True separation at this tick [l] [m]."""
    estimate: Floats
    """The robot's estimate of the optimal separation of this link [l] [m]."""
    outage: Floats
    """True outage probability of the peer's beacon of the previous tick [l] [1]; NaN before the first beacon."""
    decoded: Bools
    """True if the robot decoded that beacon [l]."""

    def __len__(self) -> int:
        return len(self.tick)

    def __repr__(self) -> str:
        return f"LinkTable({len(self):,} rows: {', '.join(vars(self))})"

    def frame(self) -> "DataFrame":
        """The table as a data frame of pandas; raises FesError if pandas is not installed."""
        return columns.frame(vars(self))


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """A run of n robots over t ticks.

    Its arrays take 8 + 40 n bytes per tick, and 49 bytes per tick and row of `links`. With three links per robot,
    this is about 190 bytes per tick and robot. Arrays of a run and of its log are equal to the bit.
    """

    scenario: Scenario
    """The scenario with every default and override."""
    summary: dict[str, Any]
    """The summary, as in `summary.json`."""
    time: Floats
    """Time since the start [t] [s]."""
    poses: Floats
    """True poses x, y and heading [t, n, 3] [m, m, rad; world frame]."""
    twists: Floats
    """Linear and angular velocity that each body holds from this tick on [t, n, 2] [m/s, rad/s]; 0 if absent."""
    links: LinkTable
    """The links in use at every tick."""
    directory: Path | None = None
    """Run directory; None if the run was not stored."""

    @property
    def digest(self) -> str:
        """SHA-256 over all ticks, poses and twists, in hexadecimal."""
        return str(self.summary["digest"])

    def __repr__(self) -> str:
        ticks, robots, _ = self.poses.shape
        return (
            f"Run({self.summary['scenario']}, seed {self.scenario.run.seed}: {robots} robots, {ticks} ticks, "
            f"{len(self.links):,} rows of links, digest {self.digest[:12]})"
        )

    def frame(self) -> "DataFrame":
        """Poses and twists as a data frame of pandas: one row per tick and robot, in this order.

        Its columns are tick, time [s], robot, x [m], y [m], heading [rad], linear [m/s] and angular [rad/s]. Raises
        FesError if pandas is not installed.
        """
        ticks, robots, _ = self.poses.shape
        poses, twists = self.poses.reshape(-1, 3), self.twists.reshape(-1, 2)
        return columns.frame(
            {
                "tick": np.repeat(np.arange(ticks), robots),
                "time": np.repeat(self.time, robots),
                "robot": np.tile(np.arange(robots), ticks),
                "x": poses[:, 0],
                "y": poses[:, 1],
                "heading": poses[:, 2],
                "linear": twists[:, 0],
                "angular": twists[:, 1],
            }
        )
