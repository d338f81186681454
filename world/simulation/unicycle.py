"""The unicycle (5), integrated exactly: with a constant twist it moves on a circular arc."""

from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from fes.extension.protocols import NoParameters
from fes.model import kinematics


class Unicycle:
    """Bodies that follow their commands exactly. Their state is their poses [n, 3]."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
        """It depends on nothing but its commands."""

    def start(self, poses: Floats) -> Floats:
        """Bodies at rest at `poses` [n, 3]."""
        return poses

    def step(self, state: Floats, twists: Floats, dt: float) -> Floats:
        """Poses after `twists` [n, 2] were held for `dt` [s]."""
        return kinematics.move(state, twists, dt)

    def poses(self, state: Floats) -> Floats:
        """The poses themselves."""
        return state
