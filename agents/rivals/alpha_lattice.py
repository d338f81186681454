"""Flocking to an alpha-lattice, after Olfati-Saber, "Flocking for multi-agent dynamic systems" (2006), Algorithm 1.

Each robot has a velocity. A force between robots nearer than the range r vanishes at the spacing d. The consensus of
velocities damps the motion, and robots put theirs into their beacons. The friction replaces the article's
gamma-agent, the common goal, by one at rest.
"""

from typing import Annotated

import numpy as np
from pydantic import Field

from fes.extension import (
    Bools,
    Bytes,
    Floats,
    Formed,
    LawContext,
    LinkGeometry,
    Neighborhood,
    NonNegative,
    Positive,
    Table,
    elementary,
)

EPSILON, BUMP, FORCE = 0.1, 0.2, 5.0
"""Constants of the sigma-norm (epsilon), of the bump function (h) and of the force (a = b), as in his simulations."""

HOLD = 1.0
"""The pull is the velocity times this [s]: the robot then has it if formation.linear_gain is 1 /s."""

DECLARED = np.dtype("<f4")
"""Type of the two components of the velocity in a beacon."""


class AlphaLatticeParameters(Table):
    """The parameters of `alpha_lattice`."""

    spacing: Positive | None = None
    """Spacing d of the lattice [m]; by default 1.4 r_min."""
    range_ratio: Annotated[float, Field(gt=1.0, le=10.0)] = 1.2
    """Range of the force as a multiple of the spacing [1] (r/d)."""
    force_gain: Positive = 0.05
    """Gain of the force [1] (c_1^alpha)."""
    consensus_gain: NonNegative = 0.5
    """Gain of the consensus of velocities [1/s] (c_2^alpha)."""
    friction: NonNegative = 0.2
    """Gain toward rest [1/s] (c_2^gamma)."""


class AlphaLattice:
    """The formation law; its state is the velocity of each robot [n, 2] [m/s; world frame]."""

    Parameters = AlphaLatticeParameters
    declared = 2 * DECLARED.itemsize
    details: tuple[str, ...] = ()

    def __init__(self, parameters: AlphaLatticeParameters, context: LawContext) -> None:
        self._parameters, self._n, self._dt = parameters, len(context.ids), context.dt
        self._spacing = parameters.spacing or 1.4 * context.objective.minimum_separation
        self._range = self._spacing * parameters.range_ratio

    def start(self) -> Floats:
        """At rest."""
        return np.zeros((self._n, 2))

    def forget(self, state: Floats, restarted: Bools) -> Floats:
        """The robots `restarted` at rest."""
        return np.where(restarted[:, None], 0.0, state)

    def step(self, state: Floats, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull of the velocity after one tick of force, consensus and friction."""
        contacts, parameters = around.contacts, self._parameters
        edges, rows = contacts.edges, contacts.edges.rows
        gradient = contacts.separation / np.sqrt(1.0 + EPSILON * np.square(contacts.separation))
        size = np.where(contacts.separation > 0.0, contacts.separation, 1.0)
        force = (
            np.where(contacts.known, parameters.force_gain * self.force(contacts.separation), 0.0) * gradient / size
        )
        agreement = parameters.consensus_gain * np.where(contacts.known, self._adjacency(contacts.separation), 0.0)
        heard = _velocities(contacts.declared)
        acceleration = np.stack(
            [
                edges.sum(force * line + agreement * (heard[:, axis] - state[rows, axis]))
                for axis, line in enumerate((contacts.dx, contacts.dy))
            ],
            axis=1,
        )
        velocity = state + self._dt * (acceleration - parameters.friction * state)
        return Formed(velocity, HOLD * velocity, _bytes(velocity))

    def force(self, separation: Floats) -> Floats:
        """phi_alpha at `separation` [m], any shape: negative where robots are nearer than the spacing."""
        excess = sigma(separation) - sigma(np.array(self._spacing))
        return self._adjacency(separation) * FORCE * excess / np.sqrt(1.0 + excess * excess)

    def _adjacency(self, separation: Floats) -> Floats:
        """a_ij at `separation` [m], any shape: 1 when near, and smoothly 0 at the range."""
        share = sigma(separation) / sigma(np.array(self._range))
        fall = 0.5 * (1.0 + elementary.sin_cos(np.pi * (np.clip(share, BUMP, 1.0) - BUMP) / (1.0 - BUMP))[1])
        return np.where(share < 1.0, fall, 0.0)


def sigma(separation: Floats) -> Floats:
    """The sigma-norm of a line of sight of length `separation` [m], any shape."""
    norm: Floats = (np.sqrt(1.0 + EPSILON * separation * separation) - 1.0) / EPSILON
    return norm


def _velocities(declared: Bytes) -> Floats:
    """The velocities in beacons [m, 2] [m/s], from their first bytes [m, b]."""
    raw = np.ascontiguousarray(declared[:, : AlphaLattice.declared])
    velocities = raw.view(DECLARED).reshape(len(raw), 2).astype(np.float64)
    return np.where(np.isfinite(velocities), velocities, 0.0)


def _bytes(velocity: Floats) -> Bytes:
    """Velocities [n, 2] [m/s] as bytes for beacons [n, b]."""
    return np.ascontiguousarray(velocity.astype(DECLARED)).view(np.uint8).reshape(len(velocity), -1)
