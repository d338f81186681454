"""Bodies in MuJoCo: differential drives with motors, friction and collisions, all in one model on one floor."""

import importlib
from typing import Any

import numpy as np

from fes.arrays import geometry
from fes.arrays.types import Floats
from fes.errors import FesError
from fes.model import counts
from fes.system import distribution
from world.config.hardware.tabletop import TabletopConfig
from world.tabletop.bodies import interface, mujoco_model

_POSE, _TWIST = 7, 6
"""Numbers of a free joint: position and quaternion, velocity and rate of turn."""


class MujocoBodies:
    """Differential drives; raises FesError where MuJoCo is not installed."""

    def __init__(self, start: Floats, config: TabletopConfig) -> None:
        self._config = config
        self._mujoco = _library()
        self._model: Any = self._mujoco.MjModel.from_xml_string(mujoco_model.mjcf(start, config))
        self._data: Any = self._mujoco.MjData(self._model)
        joints = [self._model.joint(f"free{robot}") for robot in range(len(start))]
        self._pose = np.array([joint.qposadr[0] for joint in joints])[:, None] + np.arange(_POSE)
        self._twist = np.array([joint.dofadr[0] for joint in joints])[:, None] + np.arange(_TWIST)

    def command(self, robot: int, linear: float, angular: float) -> None:
        """Let a body hold a twist from now on [m/s, rad/s; body frame], within its top speeds."""
        speed, rate = interface.limited(linear, angular, self._config)
        turning = 0.5 * self._config.track * rate
        self._data.ctrl[2 * robot] = (speed - turning) / self._config.wheel_radius
        self._data.ctrl[2 * robot + 1] = (speed + turning) / self._config.wheel_radius

    def step(self, dt: float) -> None:
        """Move all bodies for `dt` [s], a whole number of physics steps; raises FesError if the physics diverges."""
        self._mujoco.mj_step(self._model, self._data, counts.ticks_of(dt, self._config.physics_step))
        if not np.isfinite(self._data.qpos).all():
            raise FesError(f"MuJoCo diverged at {self._data.time:g} s: take a smaller tabletop.physics_step")

    def poses(self) -> Floats:
        """True poses [n, 3] [m, m, rad; table frame]."""
        x, y, _, qw, qx, qy, qz = self._data.qpos[self._pose].T
        heading = np.arctan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
        return np.stack([x, y, heading], axis=1)

    def twists(self) -> Floats:
        """True twists [n, 2] [m/s, rad/s; body frame]."""
        velocity, heading = self._data.qvel[self._twist], self.poses()[:, geometry.HEADING]
        linear = velocity[:, 0] * np.cos(heading) + velocity[:, 1] * np.sin(heading)
        return np.stack([linear, velocity[:, 5]], axis=1)


def _library() -> Any:
    try:
        return importlib.import_module("mujoco")
    except ImportError:
        raise FesError(f"bodies in MuJoCo need the extra 'mujoco': {distribution.install('mujoco')}") from None
