"""A controller that commands twists itself."""

import numpy as np

from fes.arithmetic import elementary
from fes.extension import Table
from fes.extension.controllers import ControllerContext, RobotView, Twist


class DriverParameters(Table):
    """The parameters of `Driver`."""

    goals: list[list[float]]
    """Goal of each robot, by id [m]."""


class Driver:
    """A controller that drives straight to its goal, and knows no other robot."""

    Parameters = DriverParameters
    statistics = 0

    def __init__(self, parameters: DriverParameters, context: ControllerContext) -> None:
        self._x, self._y = parameters.goals[context.id]

    def step(self, robot: RobotView) -> Twist:
        """At most 5 m/s, by the distance that is left along the heading."""
        x, y = self._x - robot.x, self._y - robot.y
        sine, cosine = (float(values[0]) for values in elementary.sin_cos(np.array([robot.heading])))
        ahead, aside = x * cosine + y * sine, y * cosine - x * sine
        bearing = float(elementary.atan2(np.array([aside]), np.array([ahead]))[0])
        return Twist(min(ahead, 5.0), 4.0 * bearing)
