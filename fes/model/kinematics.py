"""The kinematics of a unicycle (5), integrated exactly: with a constant twist it moves on a circular arc."""

import numpy as np

from fes.arithmetic import elementary
from fes.arrays import geometry
from fes.arrays.types import Floats


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


def respond(actual: Floats, commands: Floats, lag: float, dt: float) -> tuple[Floats, Floats]:
    """Mean twists over a tick, and the twists at its end [n, 2], of bodies that follow `commands` [n, 2].

    They approach them from `actual` [n, 2] in first order with the time constant `lag` [s]. The mean is the exact
    integral of that response; a lag of 0 follows at once.
    """
    if lag == 0.0:
        return commands, commands
    decay, rise = elementary.exp_and_rise(np.array([-dt / lag]), np.array([dt / lag]))
    behind = actual - commands
    return commands + behind * (lag / dt * rise), commands + behind * decay
