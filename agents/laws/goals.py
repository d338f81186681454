"""A formation law without a formation: each robot goes to a goal of its own."""

from typing import Annotated

import numpy as np
from pydantic import Field

from fes.arrays import geometry
from fes.arrays.types import Bools
from fes.extension.context import LawContext
from fes.extension.neighborhood import LinkGeometry, Neighborhood
from fes.extension.protocols import Formed
from fes.model.sensing import MAX_NUMBER
from fes.model.table import Table

Coordinate = Annotated[float, Field(ge=-MAX_NUMBER, le=MAX_NUMBER)]


class GoalsParameters(Table):
    """The parameters of `goals`."""

    goals: list[Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]] = Field(min_length=1)
    """Goal of each robot, a list of x and y [m; world frame], in the order of the robot ids. A robot whose id is
    beyond the list has no goal, and stays."""


class Goals:
    """The formation law that pulls each robot to its goal. It has no state."""

    Parameters = GoalsParameters
    declared = 0
    details: tuple[str, ...] = ()

    def __init__(self, parameters: GoalsParameters, context: LawContext) -> None:
        ids, goals = context.draws.own_ids(context.ids), np.array(parameters.goals, dtype=np.float64)
        self._has_goal = ids < len(goals)
        self._goals = goals[np.where(self._has_goal, ids, 0)]

    def start(self) -> None:
        """It has no state."""

    def forget(self, state: None, restarted: Bools) -> None:
        """It has no state."""

    def step(self, state: None, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The vector from each robot to its goal."""
        toward = self._goals - around.poses[:, : geometry.HEADING]
        return Formed(None, np.where(self._has_goal[:, None], toward, 0.0))
