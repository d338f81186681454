"""Coverage by Voronoi cells, after Cortes et al., "Coverage control for mobile sensing networks" (2004).

Each robot moves to the centroid of its cell. The cell is the set of points within its sensing radius that are nearer
to it than to any peer it hears. It is star-shaped about the robot, so it is integrated along rays. On each ray, the
cell ends at the nearest bisector or at the edge of the disc.
"""

from typing import Annotated

import numpy as np
from pydantic import Field

from fes.extension import (
    Bools,
    Contacts,
    Floats,
    Formed,
    LawContext,
    LinkGeometry,
    Neighborhood,
    Positive,
    Table,
    elementary,
    sums,
)


class VoronoiParameters(Table):
    """The parameters of `voronoi`."""

    sensing_radius: Positive | None = None
    """Radius of the disc around each robot [m]; by default the smallest separation that the team prefers (r_min)."""
    gain: Positive = 1.0
    """Share of the way to the centroid that is the pull [1]."""
    rays: Annotated[int, Field(ge=8, le=4096)] = 64
    """Number of rays along which a cell is integrated."""


class Voronoi:
    """The formation law; it has no state."""

    Parameters = VoronoiParameters
    declared = 0
    details = ("cell_area",)
    """Area of the robot's cell [m^2]."""

    def __init__(self, parameters: VoronoiParameters, context: LawContext) -> None:
        self._n, self._gain = len(context.ids), parameters.gain
        self._radius = parameters.sensing_radius or context.objective.minimum_separation
        angles = 2.0 * np.pi * np.arange(parameters.rays) / parameters.rays
        self._y, self._x = elementary.sin_cos(angles)

    def start(self) -> None:
        """No state."""

    def forget(self, state: None, restarted: Bools) -> None:
        """No state."""

    def step(self, state: None, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull toward the centroid of each robot's cell."""
        length = self.cell(around.contacts)
        angle = 2.0 * np.pi / len(self._x)
        square = length * length
        area = 0.5 * angle * sums.of_rows(square)
        moment = angle / 3.0 * (square * length)
        x, y = sums.of_rows(moment * self._x), sums.of_rows(moment * self._y)
        safe = np.where(area > 0.0, area, 1.0)  # the cell of a robot that stands on a peer may be empty
        return Formed(None, self._gain * np.stack([x / safe, y / safe], axis=1), details=area[:, None])

    def cell(self, contacts: Contacts) -> Floats:
        """Length of the cell of each robot along each ray [n, k] [m]."""
        length = np.full((self._n, len(self._x)), self._radius)
        if not len(contacts.edges):
            return length
        along = np.multiply.outer(contacts.dx, self._x) + np.multiply.outer(contacts.dy, self._y)
        half = np.where(contacts.known, 0.5 * np.square(contacts.separation), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            bisector = np.where(along > 0.0, half[:, None] / along, np.inf)
        nearest = np.minimum.reduceat(bisector, contacts.edges.starts, axis=0)
        rows = np.flatnonzero(contacts.edges.counts)
        length[rows] = np.minimum(length[rows], nearest)
        return length
