"""The robots' actuators: a body follows its command with a lag, and slips.

The lag acts first, on the command as clipped by the limits: over a tick a body holds the mean of its first-order
response. A slip s then scales both velocities by factors 1 + s N, constant for each robot, and adds a random walk of
s m/sqrt(s) and s rad/sqrt(s). N are independent normal numbers.
"""

import math

import numpy as np

from fes.arrays.types import Bools, Floats
from fes.model import kinematics
from world.config.starts import RobotsConfig
from world.simulation.hardware.normals import Normals


class Actuators:
    """The constants of the actuators of a run. Their state is the bodies' actual twists [n, 2]."""

    def __init__(self, config: RobotsConfig, seed: int, dt: float) -> None:
        self._lag, self._slip, self._dt = config.actuator_lag, config.slip, dt
        self._scale = 1.0 + config.slip * Normals(seed, "slip scale", config.number, 2).of(0)
        self._walk = Normals(seed, "slip walk", config.number, 2)

    def start(self) -> Floats:
        """Bodies at rest."""
        return np.zeros_like(self._scale)

    def step(self, actual: Floats, commands: Floats, tick: int, present: Bools) -> tuple[Floats, Floats]:
        """The twists that the bodies hold over a tick [n, 2], and the state at its end; an absent robot stands."""
        mean, after = kinematics.respond(actual, commands, self._lag, self._dt)
        if self._slip > 0.0:
            mean = mean * self._scale + self._slip / math.sqrt(self._dt) * self._walk.of(tick)
        moves = present[:, None]
        return np.where(moves, mean, 0.0), np.where(moves, after, 0.0)


def of(config: RobotsConfig, seed: int, dt: float) -> Actuators | None:
    """The actuators of a run; None where bodies follow their commands exactly."""
    return None if config.actuator_lag == 0.0 and config.slip == 0.0 else Actuators(config, seed, dt)
