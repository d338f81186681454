"""Bodies that follow their commands exactly, on circular arcs; they pass through one another."""

import numpy as np

from fes.arrays.types import Floats
from fes.model import kinematics
from world.config.hardware.tabletop import TabletopConfig
from world.tabletop.bodies import interface


class KinematicBodies:
    """Unicycles with top speeds."""

    def __init__(self, start: Floats, config: TabletopConfig) -> None:
        self._config = config
        self._poses = np.array(start, dtype=np.float64)
        self._twists = np.zeros((len(start), 2))

    def command(self, robot: int, linear: float, angular: float) -> None:
        """Let a body hold a twist from now on [m/s, rad/s; body frame], within its top speeds."""
        self._twists[robot] = interface.limited(linear, angular, self._config)

    def step(self, dt: float) -> None:
        """Move all bodies for `dt` [s], by equation (5), exactly."""
        self._poses = kinematics.move(self._poses, self._twists, dt)

    def poses(self) -> Floats:
        """True poses [n, 3] [m, m, rad; table frame]."""
        return self._poses

    def twists(self) -> Floats:
        """The twists that they hold [n, 2] [m/s, rad/s; body frame]."""
        return self._twists.copy()
