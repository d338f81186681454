"""The unicycle (5), integrated exactly: with a constant twist it moves on a circular arc."""

import numpy as np

from fes.arrays import geometry
from fes.arrays.types import Floats


def move(poses: Floats, twists: Floats, dt: float) -> Floats:
    """Poses [n, 3] after `twists` [n, 2] were held for `dt` [s]; equation (5), exactly.

    The chord of an arc of angle 2b has length v dt sin(b)/b and points along the mean heading.
    """
    half_turn = 0.5 * dt * twists[:, geometry.ANGULAR]
    chord = dt * twists[:, geometry.LINEAR] * np.sinc(half_turn / np.pi)
    middle = poses[:, geometry.HEADING] + half_turn
    moved = np.empty_like(poses)
    moved[:, geometry.X] = poses[:, geometry.X] + chord * np.cos(middle)
    moved[:, geometry.Y] = poses[:, geometry.Y] + chord * np.sin(middle)
    moved[:, geometry.HEADING] = geometry.wrap(middle + half_turn)
    return moved
