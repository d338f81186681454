"""The unicycle (5), integrated exactly: with a constant twist it moves on a circular arc."""

import numpy as np

from fes.arithmetic import elementary
from fes.arrays import geometry
from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from fes.extension.protocols import NoParameters


class Unicycle:
    """Bodies that follow their commands exactly. Their state is their poses [n, 3]."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
        """It depends on nothing but its commands."""

    def start(self, poses: Floats) -> Floats:
        """Bodies at rest at `poses` [n, 3]."""
        return poses

    def step(self, state: Floats, twists: Floats, dt: float) -> Floats:
        """Poses after `twists` [n, 2] were held for `dt` [s]."""
        return move(state, twists, dt)

    def poses(self, state: Floats) -> Floats:
        """The poses themselves."""
        return state


def move(poses: Floats, twists: Floats, dt: float) -> Floats:
    """Poses [n, 3] after `twists` [n, 2] were held for `dt` [s]; equation (5), exactly.

    The chord of an arc of angle 2b has length v dt sin(b)/b and points along the mean heading.
    """
    half_turn = 0.5 * dt * twists[:, geometry.ANGULAR]
    middle = poses[:, geometry.HEADING] + half_turn
    sine, cosine = elementary.sin_cos(np.stack([half_turn, middle]))
    is_straight = half_turn == 0.0
    shortening = np.where(is_straight, 1.0, sine[0] / np.where(is_straight, 1.0, half_turn))
    chord = dt * twists[:, geometry.LINEAR] * shortening
    moved = np.empty_like(poses)
    moved[:, geometry.X] = poses[:, geometry.X] + chord * cosine[1]
    moved[:, geometry.Y] = poses[:, geometry.Y] + chord * sine[1]
    moved[:, geometry.HEADING] = geometry.wrap(middle + half_turn)
    return moved
