"""Configurations of ten robots that were studied, with their covered area and delivery by an independent program."""

import math
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Floats
from fes.model.config import ChannelConfig, ObjectiveConfig
from world.metrics.optimum import optimal_separation

OBJECTIVE = ObjectiveConfig()
CHANNEL = ChannelConfig(model="rayleigh", reference_snr=1e7)
BEST = optimal_separation(OBJECTIVE, CHANNEL)
"""r* [m]."""


class Configuration(NamedTuple):
    """Positions, and the results to the digits that are known."""

    positions: Floats
    """x, y of ten robots [10, 2] [m]."""
    hectares: float
    """Covered area [1e4 m^2]."""
    delivery: float
    after_loss: float


def row(spacing: float) -> Floats:
    """Ten robots on a line."""
    return np.column_stack([spacing * np.arange(10.0), np.zeros(10)])


def ring(spacing: float) -> Floats:
    """A regular polygon of ten robots with sides of `spacing` [m]."""
    angle = 2.0 * math.pi * np.arange(10) / 10.0
    return spacing / (2.0 * math.sin(math.pi / 10.0)) * np.column_stack([np.cos(angle), np.sin(angle)])


def ladder(spacing: float) -> Floats:
    """Two rows of five robots."""
    return spacing * np.array([(x, y) for y in range(2) for x in range(5)], dtype=np.float64)


def patch(spacing: float) -> Floats:
    """The triangular lattice in rows of three, four and three robots."""
    rows = [(-1, 3), (0, 4), (1, 3)]
    sites = [(x - (count - 1) / 2.0, y * math.sqrt(0.75)) for y, count in rows for x in range(count)]
    return spacing * np.array(sites)


START = np.array(
    [(0, 0), (25, 25), (50, 0), (25, -25), (25, 0), (150, 0), (225, 0), (188, 63), (188, -63), (188, 0)],
    dtype=np.float64,
)
"""The paper's start."""

STUDIED = {
    "start": Configuration(START, 4.18, 0.712, 0.409),
    "row": Configuration(row(BEST), 6.40, 0.604, 0.307),
    "ring": Configuration(ring(BEST), 6.24, 0.683, 0.633),
    "ladder": Configuration(ladder(BEST), 5.76, 0.726, 0.693),
    "patch": Configuration(patch(BEST), 5.29, 0.788, 0.766),
    "wide patch": Configuration(patch(71.26), 5.57, 0.758, 0.733),
}
