"""The bodies of a scenario, and the scale between the table and the law."""

import numpy as np

from fes.arrays import geometry
from fes.arrays.types import Floats
from world.config.hardware.tabletop import TabletopConfig
from world.config.scenario import Scenario, initial_poses
from world.tabletop.bodies.interface import Bodies


def create(scenario: Scenario, config: TabletopConfig) -> Bodies:
    """The bodies of a scenario at its initial poses; raises FesError where MuJoCo is not installed."""
    start = on_table(initial_poses(scenario), config.scale)
    if config.body == "kinematic":
        from world.tabletop.bodies.kinematic import KinematicBodies

        return KinematicBodies(start, config)
    from world.tabletop.bodies.mujoco_bodies import MujocoBodies

    return MujocoBodies(start, config)


def on_table(poses: Floats, scale: float) -> Floats:
    """Poses [n, 3] of the law, as poses on the table [n, 3].

    >>> on_table(np.array([[150.0, 0.0, 0.5]]), 100.0).tolist()
    [[1.5, 0.0, 0.5]]
    """
    return _scaled(poses, 1.0 / scale)


def at_full_size(poses: Floats, scale: float) -> Floats:
    """Poses [n, 3] on the table, as poses of the law [n, 3].

    >>> at_full_size(np.array([[1.5, 0.0, 0.5]]), 100.0).tolist()
    [[150.0, 0.0, 0.5]]
    """
    return _scaled(poses, scale)


def _scaled(poses: Floats, factor: float) -> Floats:
    result = np.array(poses, dtype=np.float64)
    result[:, [geometry.X, geometry.Y]] *= factor
    return result
