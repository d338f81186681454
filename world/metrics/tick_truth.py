"""TickTruth: one tick as the metrics see it."""

from typing import NamedTuple

from fes.arrays.types import Floats
from fes.model.sensing import Telemetry
from world.simulation.truth import State


class TickTruth(NamedTuple):
    """The truth at one tick, and the robots' telemetry, for u undirected links."""

    state: State
    """The world at this tick."""
    twists: Floats
    """Twists that the bodies hold from this tick on [n, 2] [m/s, rad/s]."""
    telemetry: Telemetry
    """Links, estimates and further numbers of the robots."""
    separation: Floats
    """True separation of each of `telemetry.links.undirected` [u] [m]."""
    mean_separation: Floats
    """The same, averaged over a dither period [u] [m]; NaN for a link younger than that."""
    optimal: float
    """r* of the channel in force [m]; NaN if it has none."""
    is_changed: bool
    """True if the channel changed at this tick, or if this is the first tick."""
