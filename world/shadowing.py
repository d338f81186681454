"""Spatially correlated log-normal shadowing: the same to the bit from either end, a function of seed and positions.

The gain of the pair at a, b is deviation * g(a, b) [dB], with g standard normal over seeds. f(a, b) is a sum of K
waves sqrt(2/K) cos(k.a + q.b + phi) whose k and q are independent draws from the bivariate Cauchy law over the
decorrelation distance d0 (random Fourier features: Rahimi & Recht 2007). The characteristic function of that law is
exp(-|d|), so the correlation when one end moves by d is exp(-d/d0) (Gudmundson 1991), and when both move the
product. g is f made reciprocal, (f(a, b) + f(b, a)) / sqrt(2 (1 + exp(-2 |a - b|/d0))).
"""

import math
from dataclasses import dataclass

import numpy as np

from fes import draws, geometry
from fes.arrays import Floats, Ints
from world.radio_config import ShadowingConfig

MODES = 256
"""K; the fourth moment of the sum of K waves falls short of the normal's by 1.5/K."""

_CHUNK = 2048
"""Pairs summed over at a time: 8 KB of waves for each of the two ends."""


@dataclass(frozen=True, eq=False)
class Modes:
    """The waves of a seed, for a decorrelation distance of 1 m: deviation and distance may change during a run."""

    one: Floats
    """k [2, K] [rad/m; world frame]."""
    other: Floats
    """q [2, K] [rad/m; world frame]."""
    phase: Floats
    """phi [K] [rad]."""


def modes(seed: int) -> Modes:
    """The waves of a seed."""
    columns = np.arange(5)
    drawn = draws.uniform_ticks(draws.key(seed, "shadowing"), 0, MODES, np.zeros_like(columns), columns).T
    return Modes(_cauchy(drawn[0], drawn[1]), _cauchy(drawn[2], drawn[3]), 2.0 * math.pi * drawn[4])


def gain(waves: Modes, config: ShadowingConfig, poses: Floats, a: Ints, b: Ints, separation: Floats) -> Floats:
    """Gain [dB] of the pairs of rows a and b [p] of `poses` [n, 3], `separation` [p] [m] apart.

    Sums of products, row by row: no digit depends on other pairs, nor on the threads of a matrix product.
    """
    distance = config.decorrelation_distance
    k, q = _waves(waves.one, 0.0, poses, distance), _waves(waves.other, waves.phase, poses, distance)
    k[:, MODES:] *= -1.0  # cos(u + v) = cos u cos v - sin u sin v
    total = np.empty(len(a))
    for first in range(0, len(a), _CHUNK):
        part = slice(first, first + _CHUNK)
        i, j = a[part], b[part]
        total[part] = np.einsum("pk,pk->p", k.take(i, axis=0), q.take(j, axis=0))
        total[part] += np.einsum("pk,pk->p", k.take(j, axis=0), q.take(i, axis=0))
    scale = np.sqrt(MODES * (1.0 + np.exp(-2.0 / distance * separation)))
    gains: Floats = config.deviation * total / scale
    return gains


def _cauchy(radius: Floats, angle: Floats) -> Floats:
    """Draws [2, m] from the bivariate Cauchy law, of density (1 + k^2)^(-3/2) / (2 pi), from uniform numbers [m].

    P[|k| <= s] = 1 - 1/sqrt(1 + s^2), solved for s.
    """
    size = np.sqrt(np.square(1.0 / (1.0 - radius)) - 1.0)
    direction: Floats = np.stack([np.cos(2.0 * math.pi * angle), np.sin(2.0 * math.pi * angle)])
    return size * direction


def _waves(vectors: Floats, phase: Floats | float, poses: Floats, distance: float) -> Floats:
    """Cosines and sines of vectors.position/distance + phase, side by side [n, 2 K]."""
    kx, ky = vectors / distance
    angle = poses[:, geometry.X, None] * kx + poses[:, geometry.Y, None] * ky + phase
    return np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
