"""Controllers: a whole robot in plain Python.

A controller is a class with `Parameters`, `statistics` and `step(robot) -> Twist | Pull | Action`. Its object is its
state. There is one object per robot; `fes.extension.controller_laws` calls them in the order of their ids.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from fes.extension.context import LawContext
from fes.model.config import ObjectiveConfig
from fes.model.table import Table


class Twist(NamedTuple):
    """A twist for the body; only the limits of the configuration act on it."""

    linear: float
    """[m/s; body frame]"""
    angular: float
    """[rad/s; body frame]"""


class Pull(NamedTuple):
    """A vector from the robot to where it should go; (6), (7) make a twist of it."""

    x: float
    y: float
    """[m; world frame]"""


class Action(NamedTuple):
    """A move, and what the robot tells its peers beside its pose."""

    move: Twist | Pull
    estimates: Mapping[int, float] = {}
    """Id of a neighbor -> estimate of the optimal separation from it [m]; used where there is a link. Without one the
    present separation stands in its place."""
    statistics: Sequence[float] = ()
    """As many numbers as the class states."""


class Neighbor(NamedTuple):
    """A peer that was heard within the timeout, by its last beacon."""

    id: int
    x: float
    y: float
    heading: float
    """[m, m, rad; world frame]"""
    separation: float
    """[m]"""
    dx: float
    dy: float
    """Line of sight to it [m; world frame]."""
    bearing: float
    """Angle of the line of sight from the own heading, in [-pi, pi) [rad]."""
    age: float
    """Age of its beacon [s]."""
    estimate: float | None
    """Its own estimate for the link to this robot [m]; None if it has no such link."""
    statistics: tuple[float, ...]


class RobotView(NamedTuple):
    """The knowledge of a robot at one tick."""

    id: int
    tick: int
    dt: float
    """Tick length [s]."""
    x: float
    y: float
    heading: float
    """Own pose [m, m, rad; world frame]."""
    neighbors: tuple[Neighbor, ...]
    """By id, ascending."""


@dataclass(frozen=True, eq=False)
class ControllerContext:
    """The circumstances of one robot."""

    id: int
    dt: float
    """Tick length [s]."""
    objective: ObjectiveConfig
    laws: LawContext
    crew_id: int

    def draw(self, stream: str) -> float:
        """A uniform number in [0, 1) of this robot; put the tick into the stream for a new number at each tick."""
        ids = np.array([self.crew_id])
        return float(self.laws.draws(stream, ids, ids)[0])


class Controller(Protocol):
    """A whole robot."""

    Parameters: ClassVar[type[Table]]
    """Its parameters, in a scenario beside its name."""
    statistics: ClassVar[int]
    """Number of statistics in each beacon; 0 for a class that states none."""

    def step(self, robot: RobotView) -> Twist | Pull | Action:
        """The action of this tick."""
