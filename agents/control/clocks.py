"""Emulated clocks: the skew of each robot's clock against the team's, which shifts the robot's dither."""

from dataclasses import dataclass

from agents.laws.link_estimates import NO_SKEW
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.extension.context import Draws
from fes.model.config import AgentConfig


@dataclass(frozen=True, eq=False)
class Clocks:
    """The clocks of a crew."""

    initial: Floats
    """Skew of each clock until a fault sets it [n] [s]; positive if it is ahead of the team's."""
    is_exact: bool
    """True if no clock has a skew at any tick."""
    changes: tuple[tuple[int, int, float | None], ...]
    """Tick, row, and skew from that tick on [s], in order of time; None restores the initial skew."""


def of(config: AgentConfig, ids: Ints, draws: Draws) -> Clocks:
    """The clocks of robots `ids` [n]."""
    rows = {robot: row for row, robot in enumerate(ids.tolist())}
    own = [(fault.tick, rows[fault.robot], fault.skew) for fault in config.faults if fault.robot in rows]
    changes = tuple(sorted(own, key=lambda change: change[0]))
    is_exact = config.clock_skew == 0.0 and all(skew is None for _, _, skew in changes)
    ahead = 2.0 * draws("clock skew", ids, ids) - 1.0
    return Clocks(config.clock_skew * ahead, is_exact, changes)


def skew(clocks: Clocks, tick: int, edges: Edges) -> Floats:
    """Skew of the clock of each link's robot at a tick [l] [s], or [1] if all clocks are exact."""
    return NO_SKEW if clocks.is_exact else ahead(clocks, tick).take(edges.rows)


def ahead(clocks: Clocks, tick: int) -> Floats:
    """Skew of each robot's clock at a tick [n] [s]."""
    skews = clocks.initial
    if clocks.changes:
        skews = skews.copy()
        for start, row, value in clocks.changes:
            if start > tick:
                break
            skews[row] = clocks.initial[row] if value is None else value
    return skews
