"""Robots' own clocks: how far each is ahead of the team's, and so how far its dither is out of step."""

from dataclasses import dataclass

from agents.laws import perturbation
from fes.arrays import draws
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.model.config import AgentConfig


@dataclass(frozen=True, eq=False)
class Clocks:
    """The clocks of a crew."""

    drawn: Floats
    """How far each is ahead of the team's [n] [s], as long as nothing is set."""
    right: bool
    """Whether all are right at all times."""
    changes: tuple[tuple[int, int, float | None], ...]
    """Tick, row and what is set from that tick on [s]; None: as it was drawn. In order of time."""


def of(config: AgentConfig, ids: Ints) -> Clocks:
    """The clocks of robots `ids` [n]."""
    rows = {robot: row for row, robot in enumerate(ids.tolist())}
    mine = [(fault.tick, rows[fault.robot], fault.skew) for fault in config.faults if fault.robot in rows]
    changes = tuple(sorted(mine, key=lambda change: change[0]))
    right = config.clock_skew == 0.0 and all(skew is None for _, _, skew in changes)
    return Clocks(drawn(config, ids), right, changes)


def drawn(config: AgentConfig, ids: Ints) -> Floats:
    """How far the clock of each robot is ahead of the team's [n] [s]: a function of (seed, robot)."""
    ahead = 2.0 * draws.uniform_pairs(draws.key(config.seed, "clock skew"), ids, ids) - 1.0
    return config.clock_skew * ahead


def skew(clocks: Clocks, tick: int, edges: Edges) -> Floats:
    """How far the clock of each link's robot is ahead at a tick [l] [s], or [1] if all are right."""
    if clocks.right:
        return perturbation.ON_TIME
    ahead = clocks.drawn
    if clocks.changes:
        ahead = ahead.copy()
        for at, row, value in clocks.changes:
            if at > tick:
                break
            ahead[row] = clocks.drawn[row] if value is None else value
    return ahead.take(edges.rows)
