"""A formation law that tries to make robots collide."""

import numpy as np

from fes.arithmetic import elementary
from fes.arrays.types import Bools, Floats, Ints
from fes.extension import LawContext, LinkGeometry, Neighborhood
from fes.extension.protocols import Formed

PATROL, PURSUE, SQUEEZE, THRASH = range(4)
"""Roles: to and fro between two goals, toward the nearest peer, toward one point, in random directions."""

FORCE = 1e4
"""Length of a pull [m]: the filter clips it."""

PERIOD = 10.0
"""Time after which a robot on patrol turns back [s]."""


class Adversary:
    """A formation law with a role for each robot."""

    declared = 0
    details: tuple[str, ...] = ()

    def __init__(self, roles: Ints, goals: Floats, context: LawContext) -> None:
        """`goals` [n, 2] [m]: the place of a robot on patrol, and the point of a squeeze."""
        self._roles, self._goals, self._context = roles, goals, context

    def start(self) -> Floats | None:
        """The places at which the patrols began are not known yet."""
        return None

    def forget(self, state: Floats | None, restarted: Bools) -> Floats | None:
        """No robot of a study restarts."""
        return state

    def step(self, state: Floats | None, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull of each robot's role."""
        here = around.poses[:, :2]
        begun = here.copy() if state is None else state
        is_return = int(around.tick * around.dt / PERIOD) % 2 == 1
        pulls = {
            PATROL: (begun if is_return else self._goals) - here,
            PURSUE: FORCE * self._toward_nearest(around, here),
            SQUEEZE: FORCE * (self._goals - here),
            THRASH: FORCE * self._random(int(around.tick * around.dt)),
        }
        pull = np.zeros_like(here)
        for role, of_role in pulls.items():
            pull = np.where((self._roles == role)[:, None], of_role, pull)
        return Formed(begun, pull)

    def _toward_nearest(self, around: Neighborhood, here: Floats) -> Floats:
        contacts, result = around.contacts, np.zeros_like(here)
        nearest = contacts.edges.first_smallest(np.where(contacts.known, contacts.separation, np.inf))
        rows = contacts.edges.rows[nearest]
        result[rows] = np.stack([contacts.x[nearest], contacts.y[nearest]], axis=1) - here[rows]
        return result

    def _random(self, second: int) -> Floats:
        ids = self._context.ids
        sine, cosine = elementary.sin_cos(2.0 * np.pi * self._context.draws(f"thrash {second}", ids, ids))
        return np.stack([cosine, sine], axis=1)
