"""Scheduled deaths and hangs, for real: `fes run` does to processes what its scenario has happen to robots.

A robot that dies has its process killed, and a new one started where it is to come back; one that hangs has its
process stopped, and continued in time. The world decides from which tick on a robot takes part: what happens to
processes here changes no digit.
"""

import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

import numpy as np

from console.connect import observer
from fes.errors import Unavailable
from fes.protocol.report import Report
from fes.transport.bus import Bus
from world.config.events import ParticipationChange
from world.config.scenario import Scenario

AHEAD = 1.0
"""So long [s; wall clock] before its tick a process is continued: one that was stopped for longer than its lease has
a new session to open. And so far the world may be ahead of its last report."""

STALLED = 1.0
"""When no report comes for this long [s], the world may be waiting for a process that is stopped."""


@dataclass(frozen=True)
class ProcessControl:
    """What can be done to the agent of an `--id`."""

    kill: Callable[[str], Awaitable[None]]
    start: Callable[[str], Awaitable[None]]
    stop: Callable[[str], None]
    """It goes no further, without ending."""
    proceed: Callable[[str], None]
    away: Callable[[float], Awaitable[None]]
    """The world dies, and another goes on after so long [s]."""


async def enact(bus: Bus, run: str, timeout: float, scenario: Scenario, control: ProcessControl, alone: bool) -> None:
    """Follow a run until it is over, and do to its processes what their robots and its world go through.

    What only robots go through is done where each has a process `alone`.

    A robot that is to come back has a new process as soon as its old one is gone: it joins, and waits for its tick.
    One that is back within a second of wall clock keeps its process: to the others it is a new one all the same. One
    that hangs until the end is killed then, as nobody could tell it that the run is over. However this ends, no
    process stays stopped: where the world is lost from sight, those that are to wake go on, as it may wait for them.
    """
    schedule = scenario.participation if alone else {}
    deaths = list(scenario.world_deaths.items())
    due = [(tick, planned) for tick, planned in schedule.items() if planned.gone.any()]
    stopped: dict[int, int | None] = {}
    over = False
    try:
        with contextlib.suppress(Unavailable):  # it left early: that is for others to tell
            async for report in observer.reports(bus, run, timeout, STALLED):
                while report is not None and due and report.tick >= due[0][0]:
                    tick, planned = due.pop(0)
                    for robot in np.flatnonzero(planned.gone & ~planned.hung).tolist():
                        back = _back(schedule, robot, tick)
                        if back is not None and back <= _soon(report):
                            continue  # the world may have taken its process in again
                        await control.kill(str(robot))
                        if back is not None:
                            await control.start(str(robot))
                    for robot in np.flatnonzero(planned.hung).tolist():
                        control.stop(str(robot))
                        stopped[robot] = _back(schedule, robot, tick)
                while report is not None and deaths and report.tick >= deaths[0][0]:
                    await control.away(deaths.pop(0)[1])
                for robot in _needed(stopped, report):
                    del stopped[robot]
                    control.proceed(str(robot))
            over = True
        for robot in [robot for robot, tick in stopped.items() if over or tick is None]:
            await control.kill(str(robot))
    finally:
        for robot in stopped:
            control.proceed(str(robot))


def _back(schedule: dict[int, ParticipationChange], robot: int, after: int) -> int | None:
    """The tick after `after` at which a robot comes back; None if it does not."""
    return next((tick for tick, planned in schedule.items() if tick > after and planned.back[robot]), None)


def _soon(report: Report) -> float:
    """The tick that the world comes to in a moment."""
    return report.tick + report.ticks_per_s * AHEAD


def _needed(stopped: dict[int, int | None], report: Report | None) -> list[int]:
    """Which of the `stopped` robots, each with the tick at which it is to go on, the world needs now or soon."""
    waking = {robot: tick for robot, tick in stopped.items() if tick is not None}
    if not waking:
        return []
    soon = _soon(report) if report is not None else min(waking.values())
    return [robot for robot, tick in waking.items() if tick <= soon]
