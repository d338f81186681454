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
    """A twist of the body: linear and angular velocity. Only the scenario's limits and safe separation act on it."""

    linear: float
    """[m/s; body frame]"""
    angular: float
    """[rad/s; body frame]"""


class Pull(NamedTuple):
    """A vector from the robot to where it should go; the paper's controller (6), (7) turns it into a twist."""

    x: float
    y: float
    """[m; world frame]"""


class Action(NamedTuple):
    """A move, and what the robot tells its peers beside its pose."""

    move: Twist | Pull
    """The motion of this tick."""
    estimates: Mapping[int, float] = {}
    """Id of a neighbor -> estimate of the optimal separation from it [m]. It is used where there is a link; without
    an estimate, the beacon holds the present separation instead."""
    statistics: Sequence[float] = ()
    """Numbers for the beacon [q]: as many as the class states in `statistics`, or none for zeros."""


class Neighbor(NamedTuple):
    """A peer that was heard within the timeout, by its last beacon."""

    id: int
    """Id of the peer."""
    x: float
    y: float
    heading: float
    """Its pose in that beacon [m, m, rad; world frame]."""
    separation: float
    """Length of the line of sight to it [m]."""
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
    """Statistics in its beacon [q]."""


class RobotView(NamedTuple):
    """The knowledge of a robot at one tick."""

    id: int
    """Id of the robot."""
    tick: int
    """Number of the tick, from 0."""
    dt: float
    """Tick length [s]."""
    x: float
    y: float
    heading: float
    """Own pose [m, m, rad; world frame]."""
    neighbors: tuple[Neighbor, ...]
    """The peers heard within the timeout, by id, ascending."""


@dataclass(frozen=True, eq=False)
class ControllerContext:
    """The circumstances of one robot."""

    id: int
    """Id of the robot."""
    dt: float
    """Tick length [s]."""
    objective: ObjectiveConfig
    """The separations that the team prefers."""
    laws: LawContext
    """The context of all robots of its process."""
    crew_id: int
    """Id of the robot in that context; `id` outside of stacked runs."""

    def draw(self, stream: str) -> float:
        """A uniform number in [0, 1) of this robot. For a new number at each tick, put the tick into `stream`."""
        ids = np.array([self.crew_id])
        return float(self.laws.draws(stream, ids, ids)[0])


class Controller(Protocol):
    """A whole robot. One object per robot; the object is the state of the robot, and must pickle."""

    Parameters: ClassVar[type[Table]]
    """Its parameters, in a scenario beside its name."""
    statistics: ClassVar[int]
    """Number of statistics in each beacon; 0 for a class that states none."""

    def step(self, robot: RobotView) -> Twist | Pull | Action:
        """The action of this tick."""
