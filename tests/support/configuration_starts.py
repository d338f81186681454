"""Starts of teams that take up a configuration: kinds of random starts, connected, and the paper's."""

from collections.abc import Callable

import numpy as np

from fes.arrays.types import Floats
from fes.shapes.patch import patch
from tests.support.configurations import START

CONNECTED = 145.0
"""Separation within which each random start is connected [m]."""

LONG_LINK = 148.0
"""Links of the chain of a `clump` [m]."""

Generator = np.random.Generator


def distances(positions: Floats) -> Floats:
    """Distance of each two of `positions` [n, 2] [m] [n, n]; infinite to itself."""
    x, y = positions.T
    result: Floats = np.hypot(np.subtract.outer(x, x), np.subtract.outer(y, y))
    np.fill_diagonal(result, np.inf)
    return result


def is_connected(distance: Floats, reach: float) -> bool:
    """True if robots at these distances [n, n] [m] are connected by links within `reach` [m]."""
    joined = np.arange(len(distance)) == 0
    while True:
        grown = joined | (distance[joined] <= reach).any(axis=0)
        if (grown == joined).all():
            return bool(joined.all())
        joined = grown


def scattered(n: int, side: float, apart: float, random: Generator) -> Floats:
    """Positions [n, 2] [m], uniform in a square of `side` [m], and at least `apart` [m] apart."""
    positions: list[Floats] = []
    while len(positions) < n:
        place = random.uniform(0.0, side, 2)
        if all(np.hypot(*(place - other)) >= apart for other in positions):
            positions.append(place)
    return np.array(positions)


def connected(n: int, side: float, random: Generator) -> Floats:
    """As `scattered`, 10 m apart, and connected; drawn until they are."""
    while True:
        positions = scattered(n, side, 10.0, random)
        if is_connected(distances(positions), CONNECTED):
            return positions


def clusters(n: int, random: Generator) -> Floats:
    """Two halves with a gap of 130 m."""
    half = n // 2
    side = 18.0 * np.sqrt(n / 2.0)
    left, right = scattered(half, side, 8.0, random), scattered(n - half, side, 8.0, random)
    right[:, 0] += left[:, 0].max() + 130.0 - right[:, 0].min()
    # the nearest two of the halves may differ in y: move the right half along y until they are in range
    near = np.argmin(right[:, 0]), np.argmax(left[:, 0])
    right[:, 1] += left[near[1], 1] - right[near[0], 1]
    return np.concatenate([left, right])


def patches(n: int, random: Generator) -> Floats:
    """Two patches that halves of the team have formed, turned at random, with a gap of 120 to 149 m."""
    both = []
    for half in (n // 2, n - n // 2):
        turn = random.uniform(-np.pi, np.pi)
        x, y = 71.26 * patch(half, 1).slots.T
        both.append(np.stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y], axis=1))
    gap, way = random.uniform(120.0, 149.0), 1000.0
    while np.sqrt(((both[0][:, None] - both[1] - (way, 0.0)) ** 2).sum(axis=-1)).min() > gap:
        way -= 0.01
    return np.concatenate([both[0], both[1] + (way, 0.0)])


def row(spacing: float, n: int, random: Generator) -> Floats:
    """A line along x with sideways noise."""
    return np.stack([spacing * np.arange(n), random.normal(0.0, 1.0, n)], axis=1)


def clump(n: int, random: Generator) -> Floats:
    """Half of the robots close together, the others in a chain of links near the radio's range that wanders off."""
    half = n - n // 2
    positions = list(scattered(half, 12.0 * np.sqrt(n / 2.0), 6.0, random))
    direction = random.uniform(-np.pi, np.pi)
    while len(positions) < n:
        direction += random.uniform(-0.6, 0.6)
        positions.append(positions[-1] + LONG_LINK * np.array([np.cos(direction), np.sin(direction)]))
    return np.array(positions)


STARTS: dict[str, Callable[[int, Generator], Floats]] = {
    "paper": lambda n, random: START.copy(),
    "dense": lambda n, random: connected(n, 30.0 * np.sqrt(n), random),
    "medium": lambda n, random: connected(n, 68.0 * np.sqrt(n), random),
    "sparse": lambda n, random: connected(n, 105.0 * np.sqrt(n), random),
    "clusters": clusters,
    "line": lambda n, random: row(60.0, n, random),
    "longline": lambda n, random: row(130.0, n, random),
    "clump": clump,
    "patches": patches,
}


def poses(kind: str, n: int, seed: int) -> Floats:
    """The start of this kind with random headings [n, 3] [m, m, rad]."""
    random = np.random.default_rng([seed, n, *kind.encode()])
    positions = STARTS[kind](n, random)
    return np.column_stack([positions, random.uniform(-np.pi, np.pi, len(positions))])
