"""Spatially correlated log-normal shadowing: the same to the bit from either end, a function of seed and positions.

The gain of the pair at a, b is deviation * g(a, b) [dB], with g standard normal over seeds. f(a, b) is a sum of K
waves sqrt(2/K) cos(k.a + q.b + phi). Its k and q are independent draws from the bivariate Cauchy law over the
decorrelation distance d0 (random Fourier features: Rahimi & Recht 2007). The characteristic function of that law is
exp(-|d|). So the correlation is exp(-d/d0) when one end moves by d (Gudmundson 1991), and the product when both move.
g is f made reciprocal, (f(a, b) + f(b, a)) / sqrt(2 (1 + exp(-2 |a - b|/d0))).

The q of each wave is the k of the next. The two are still independent, as the correlation requires. Sharing them
halves the number of cosines per robot, which dominate the cost.
"""

import math
from dataclasses import dataclass

import numpy as np

from fes.arithmetic import draws, elementary, sums
from fes.arrays import geometry
from fes.arrays.types import Floats, Ints
from world.config.radio import ShadowingConfig

MODES = 256
"""K; the fourth moment of the sum of K waves falls short of the normal's by 1.5/K."""

_CHUNK = 64
"""Number of pairs summed at a time: their terms fit a processor's cache."""


@dataclass(frozen=True, eq=False)
class Modes:
    """The waves of a seed, for a decorrelation distance of 1 m: deviation and distance may change during a run."""

    vectors: Floats
    """k [2, K] [rad/m; world frame]."""
    phase: Floats
    """phi [K] [rad]."""


def modes(seed: int) -> Modes:
    """The waves of a seed.

    P[|k| <= s] = 1 - 1/sqrt(1 + s^2) in the bivariate Cauchy law, of density (1 + k^2)^(-3/2) / (2 pi); the size
    is this solved for s.
    """
    columns = np.arange(3)
    drawn = draws.uniform_ticks(draws.key(seed, "shadowing"), 0, MODES, np.zeros_like(columns), columns)
    size = np.sqrt(np.square(1.0 / (1.0 - drawn[:, 0])) - 1.0)
    angle = 2.0 * math.pi * drawn[:, 1]
    sine, cosine = elementary.sin_cos(angle)
    return Modes(size * np.stack([cosine, sine]), 2.0 * math.pi * drawn[:, 2])


def gain(waves: Modes, config: ShadowingConfig, poses: Floats, a: Ints, b: Ints, separation: Floats) -> Floats:
    """Gain [dB] of the pairs of rows a and b [p] of `poses` [n, 3], `separation` [p] [m] apart.

    Sums of products, term by term along the first axis: no digit depends on other pairs, nor on a matrix product.
    """
    distance = config.decorrelation_distance
    first_end, second_end = _ends(waves, poses, distance)
    total = np.empty(len(a))
    for first in range(0, len(a), _CHUNK):
        part = slice(first, first + _CHUNK)
        i, j = a[part], b[part]
        total[part] = sums.of_columns(first_end.take(i, axis=1) * second_end.take(j, axis=1))
        total[part] += sums.of_columns(first_end.take(j, axis=1) * second_end.take(i, axis=1))
    scale = np.sqrt(MODES * (1.0 + elementary.exp(-2.0 / distance * separation)))
    gains: Floats = config.deviation * total / scale
    return gains


def _ends(waves: Modes, poses: Floats, distance: float) -> tuple[Floats, Floats]:
    """The factors of each robot as first and as second end of a pair [2 K, n]; their products add up to f.

    cos(u + v) = cos u cos v - sin u sin v, with u = k.a and v = q.b + phi.
    """
    kx, ky = (waves.vectors / distance)[:, :, None]
    sine, cosine = elementary.sin_cos(poses[:, geometry.X] * kx + poses[:, geometry.Y] * ky)
    first_end = np.concatenate([cosine, -sine])
    cosine, sine = np.roll(cosine, -1, axis=0), np.roll(sine, -1, axis=0)
    across, along = elementary.sin_cos(waves.phase[:, None])
    second_end = np.concatenate([cosine * along - sine * across, sine * along + cosine * across])
    return first_end, second_end
