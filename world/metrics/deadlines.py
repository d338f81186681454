"""Deadlines of the live clock: commands that had not arrived when their tick ended."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fes.arrays.types import Bools, Ints

COMMAND_TIMEOUT = 0.25
"""A robot without a command younger than this [s] stops."""


@dataclass(eq=False)
class Deadlines:
    """Counts per robot [n]; a deadline is the end of a tick in which the robot takes part."""

    due: Ints
    """Deadlines of ticks in which the robot took part."""
    missed: Ints
    """Deadlines without the command of their tick, at which the robot held an older command."""
    stopped: Ints
    """Missed deadlines at which the last command was older than COMMAND_TIMEOUT."""
    late: Ints
    """Commands that arrived after their deadline: a property of the machine, which no log can reproduce."""
    slipped: float = 0.0
    """Total delay of the world's own ticks [s]."""

    def add(self, tick: int, present: Bools, command_ticks: Ints) -> None:
        """Add a tick; `command_ticks` [n] is the tick of the command that each robot follows, -1 for none."""
        self.due += present
        self.missed += present & (command_ticks < tick)
        self.stopped += present & (command_ticks < 0)

    def table(self) -> dict[str, Any]:
        """The table `deadlines` of a summary."""
        due = int(self.due.sum())
        return {
            "due": self.due.tolist(),
            "missed": self.missed.tolist(),
            "stopped": self.stopped.tolist(),
            "late": self.late.tolist(),
            "missed_share": int(self.missed.sum()) / due if due else None,
            "slipped_s": self.slipped,
        }


def no_deadlines(robots: int) -> Deadlines:
    """Deadlines at the start of a run."""
    due, missed, stopped, late = (np.zeros(robots, dtype=np.int64) for _ in range(4))
    return Deadlines(due, missed, stopped, late)
