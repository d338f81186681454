"""Shapes that a mission may ask for: places [n, 2] [link lengths], in the order of their use."""

import numpy as np

from fes.arithmetic import elementary
from fes.arrays.types import Floats


def line(n: int) -> Floats:
    """All robots on one line, along x."""
    return np.stack([np.arange(n).astype(np.float64), np.zeros(n)], axis=1)


def ring(n: int) -> Floats:
    """All robots on one circle; for fewer than three robots a line."""
    if n < 3:
        return line(n)
    turn = 2.0 * np.pi / n
    radius = 0.5 / elementary.sin_cos(np.array([0.5 * turn]))[0]
    sine, cosine = elementary.sin_cos(turn * np.arange(n).astype(np.float64))
    return np.stack([radius * cosine, radius * sine], axis=1)


def ladder(n: int) -> Floats:
    """Two lines side by side; with an odd number, one of them is a robot longer."""
    place = np.arange(n)
    return np.stack([(place // 2).astype(np.float64), (place % 2).astype(np.float64)], axis=1)
