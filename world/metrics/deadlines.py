"""How robots keep the pace of the live clock: commands that were not there when their tick was over."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fes.arrays.types import Bools, Ints

COMMAND_TIMEOUT = 0.25
"""A robot without a command younger than this [s] stops."""


@dataclass(eq=False)
class Deadlines:
    """Counts of each robot [n]; a deadline is the end of a tick in which the robot takes part."""

    due: Ints
    missed: Ints
    """Deadlines at which the command of that tick was not there, so that an older one was held."""
    stopped: Ints
    """Of them, those at which the last command was older than COMMAND_TIMEOUT."""
    late: Ints
    """Commands that came after their deadline: what the machine did, which no log can tell again."""
    slipped: float = 0.0
    """How far the world's own ticks were late in all [s]."""

    def add(self, tick: int, present: Bools, spoken: Ints) -> None:
        """One more tick; `spoken` [n] is the tick of the command that each robot follows, -1 for none."""
        self.due += present
        self.missed += present & (spoken < tick)
        self.stopped += present & (spoken < 0)

    def table(self) -> dict[str, Any]:
        """What a summary tells of them."""
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
    """Of a run that begins."""
    due, missed, stopped, late = (np.zeros(robots, dtype=np.int64) for _ in range(4))
    return Deadlines(due, missed, stopped, late)
