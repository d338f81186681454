"""The plan of a set of marks: which robot takes which slot, and the path there. Each robot makes it alone.

A plan is a pure function of the marks' bytes. So robots that know the same marks have the same plan, and nothing is
negotiated.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from agents.configuration import assignment, connection
from fes.arithmetic import elementary, sums
from fes.arrays import geometry
from fes.arrays.types import Floats, Ints
from fes.shapes.choice import Offsets, shape

DIRECT, CONTRACT, NONE = 0, 1, 2
"""Kinds of plan: straight to the slots; closer together, until a straight path exists; no plan yet."""

NO_SLOT = -1

TIE = 1e-3
"""Weight of the term that decides between equally good assignments [m^2]. Rounding would decide otherwise."""

BETTER = 0.1
"""A later orientation is taken if it saves more than this [m^2]."""

CLEARANCE = 1.2
"""A contraction brings no two robots closer than this many safe separations."""

MOST_CONTRACTION = 0.5
"""Least share of its size to which a team contracts in one plan."""

HOLD = 0.99
"""A contraction to more than this share of the size makes no progress, and a tight team would wait forever. Then
`FINER` times as many orientations are tried."""

FINER = 4


class Settings(NamedTuple):
    """The settings of a plan; all robots of a team have the same."""

    configuration: str
    offsets: Offsets
    losses: int
    orientations: int
    keep_range: float
    clearance: float
    """A contraction brings no two robots closer than this [m]."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A plan of n robots. Robot i goes to bases[i] + s offsets[i], with the spacing s and the dither added to s."""

    ids: Ints
    """Ids within the run, ascending [n]."""
    kind: int
    """DIRECT or CONTRACT."""
    slots: Ints
    """Slot of each robot [n]; NO_SLOT in a contraction."""
    marks: Floats
    """Position of each robot when the plan begins [n, 2] [m; world frame]."""
    bases: Floats
    """Mean of the marks, or each robot's goal in a contraction [n, 2] [m; world frame]."""
    offsets: Floats
    """Slot of each robot relative to the mean [n, 2] [link lengths; world frame]; 0 in a contraction."""
    spacing: float
    """Mean of the marked estimates, each of which counts as at most `keep_range` [m]."""

    def farthest(self, dither: float) -> float:
        """D: the longest path of a robot [m], from its mark to its goal, with `dither` [m] added to the spacing."""
        x, y = (self.marks - self.bases - (self.spacing + dither) * self.offsets).T
        return float(geometry.separation(x, y).max())


@lru_cache(maxsize=256)
def plan(ids: bytes, marks: bytes, settings: Settings) -> Plan:
    """The plan of robots `ids` (int64, ascending) [n] with `marks` (float32) [n, 3] [m]: x, y and estimate."""
    values = np.frombuffer(marks, dtype=np.float32).reshape(-1, 3).astype(np.float64)
    robots, positions = np.frombuffer(ids, dtype=np.int64), values[:, :2]
    # No plan keeps links beyond its reach. So a false estimate, however large, moves the mean by a bounded length.
    estimates = np.minimum(values[:, 2], settings.keep_range - connection.MARGIN)
    center, spacing = sums.of_columns(positions) / len(values), sums.mean(estimates)
    distance = geometry.distances(positions)
    reach = connection.reach(distance, settings.keep_range)
    best = _direct(positions, center, spacing, reach, settings, settings.orientations)
    if best is None:
        share = _contraction(distance, settings.clearance)
        if share > HOLD:
            best = _direct(positions, center, spacing, reach, settings, FINER * settings.orientations)
    if best is None:
        bases = center + share * (positions - center)
        nowhere = np.full(len(robots), NO_SLOT)
        return Plan(robots, CONTRACT, nowhere, positions, bases, np.zeros_like(positions), spacing)
    slots, offsets = best
    return Plan(robots, DIRECT, slots, positions, np.zeros_like(positions) + center, offsets, spacing)


def _direct(
    positions: Floats, center: Floats, spacing: float, reach: float, settings: Settings, orientations: int
) -> tuple[Ints, Floats] | None:
    """The slots [n] and offsets [n, 2] with the least sum of squared distances that keep the team connected."""
    n = len(positions)
    team = shape(settings.configuration, n, settings.losses, settings.offsets)
    place = np.arange(n).astype(np.float64)
    tie = TIE * np.multiply.outer(place, place) / (n * n)
    sine, cosine = elementary.sin_cos(2.0 * np.pi * np.arange(orientations) / orientations)
    best, least = None, np.inf
    for turn in range(orientations):
        offsets = _rotated(team.slots, sine[turn], cosine[turn])
        squares = _squares(positions - center, spacing * offsets)
        if not assignment.at_least(squares) < least - BETTER:
            continue
        slots = assignment.least_sum(squares + tie)
        total = sums.total(squares[np.arange(n), slots])
        goals = center + spacing * offsets[slots]
        if total < least - BETTER and connection.is_kept(positions, goals, reach):
            best, least = (slots, offsets[slots]), total
    return best


def _contraction(distance: Floats, clearance: float) -> float:
    """The share of its size to which a team contracts, by the `distance` of each two robots [n, n] [m]."""
    apart = distance.copy()
    apart[np.diag_indices(len(apart))] = np.inf
    return max(MOST_CONTRACTION, clearance / max(float(apart.min()), clearance))


def _rotated(offsets: Floats, sine: float, cosine: float) -> Floats:
    """`offsets` [n, 2], turned counter-clockwise."""
    x, y = offsets.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)


def _squares(positions: Floats, places: Floats) -> Floats:
    """Squared distance from each of `positions` [n, 2] to each of `places` [n, 2] [n, n] [m^2]."""
    dx, dy = (positions[:, axis, None] - places[:, axis] for axis in (0, 1))
    squares: Floats = dx * dx + dy * dy
    return squares
