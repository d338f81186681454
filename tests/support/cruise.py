"""A controller that ignores its peers and drives in a circle at full speed: a test knows its motion."""

from fes.extension import Table
from fes.extension.controllers import RobotView, Twist


class Cruise:
    """Drives in a circle."""

    class Parameters(Table):
        linear: float = 20.0
        """[m/s]"""
        angular: float = 0.5
        """[rad/s]"""

    def __init__(self, parameters: "Cruise.Parameters", context: object) -> None:
        self._twist = Twist(parameters.linear, parameters.angular)

    def step(self, robot: RobotView) -> Twist:
        return self._twist
