"""Scheduled deaths, for real: `fes run` kills the processes that its scenario has die, and starts them again.

The world decides from which tick on a robot takes part; what happens to processes here changes no digit.
"""

from collections.abc import Awaitable, Callable

import numpy as np

from console import observer, view
from fes.bus import Bus
from world.scenario import Scenario

Act = Callable[[str], Awaitable[None]]


async def enact(bus: Bus, run: str, timeout: float, scenario: Scenario, kill: Act, start: Act) -> None:
    """Follow a run of one process a robot until it is over, and `kill` and `start` agents by their `--id`.

    A robot that is to come back has a new process as soon as its old one is gone: it joins, and waits for its tick.
    """
    due = [(tick, planned.gone) for tick, planned in scenario.attendance.items() if planned.gone.any()]
    async for report in observer.reports(bus, run, timeout, view.IDLE):
        while report is not None and due and report.tick >= due[0][0]:
            tick, gone = due.pop(0)
            for robot in np.flatnonzero(gone).tolist():
                await kill(str(robot))
                if any(at > tick and planned.back[robot] for at, planned in scenario.attendance.items()):
                    await start(str(robot))
