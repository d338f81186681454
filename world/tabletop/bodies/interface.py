"""The interface of a team of bodies on a table."""

from typing import Protocol

from fes.arrays.types import Floats
from world.config.hardware.tabletop import TabletopConfig


class Bodies(Protocol):
    """The bodies of n robots. Their meters are those of the table."""

    def command(self, robot: int, linear: float, angular: float) -> None:
        """Let a body hold a twist from now on [m/s, rad/s; body frame], within its top speeds."""

    def step(self, dt: float) -> None:
        """Move all bodies for `dt` [s]."""

    def poses(self) -> Floats:
        """True poses [n, 3] [m, m, rad; table frame]."""

    def twists(self) -> Floats:
        """True twists [n, 2] [m/s, rad/s; body frame]."""


def limited(linear: float, angular: float, config: TabletopConfig) -> tuple[float, float]:
    """A twist within the top speeds of a body [m/s, rad/s]."""
    return (
        min(max(linear, -config.linear_limit), config.linear_limit),
        min(max(angular, -config.angular_limit), config.angular_limit),
    )
