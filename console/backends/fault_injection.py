"""Scheduled deaths and hangs of robots and of the world, applied to their processes.

The process of a robot that dies is killed, and restarted if the robot returns. The process of a robot that
hangs is suspended, and resumed in time. The world decides from which tick on a robot takes part, so the fate of
processes changes no digit.
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
"""Lead [s; wall clock] with which a process is resumed before its tick.

A process that was suspended past its lease must open a new session, and the world may be this far ahead of its last
report."""

STALLED = 1.0
"""Time without a report [s] after which the world may be waiting for a suspended process."""


@dataclass(frozen=True)
class ProcessControl:
    """Operations on the agents, by their `--id`, and on the world."""

    kill: Callable[[str], Awaitable[None]]
    start: Callable[[str], Awaitable[None]]
    stop: Callable[[str], None]
    """Suspend the agent."""
    resume: Callable[[str], None]
    replace_world: Callable[[float], Awaitable[None]]
    """Kill the world, and start another after this time [s]."""


async def enact(bus: Bus, run: str, timeout: float, scenario: Scenario, control: ProcessControl, alone: bool) -> None:
    """Follow a run to its end, and apply the scheduled faults of its robots and of its world to their processes.

    Faults of robots are applied only where each robot has a process `alone`.

    A robot that returns gets a new process as soon as the old one has ended; the process joins and waits for its
    tick. A robot that returns within a second of wall clock keeps its process. A process that hangs until the end is
    killed then, because it cannot receive that the run is over. No process stays suspended after this call: if the
    world disappears, processes due to resume do so, because the world may be waiting for them.
    """
    schedule = scenario.participation if alone else {}
    deaths = list(scenario.world_deaths.items())
    due = [(tick, planned) for tick, planned in schedule.items() if planned.gone.any()]
    stopped: dict[int, int | None] = {}
    over = False
    try:
        with contextlib.suppress(Unavailable):  # the supervisor reports a world that left early
            async for report in observer.reports(bus, run, timeout, STALLED):
                while report is not None and due and report.tick >= due[0][0]:
                    tick, planned = due.pop(0)
                    for robot in np.flatnonzero(planned.gone & ~planned.hung).tolist():
                        return_tick = _return_tick(schedule, robot, tick)
                        if return_tick is not None and return_tick <= _soon(report):
                            continue  # the process may already take part again
                        await control.kill(str(robot))
                        if return_tick is not None:
                            await control.start(str(robot))
                    for robot in np.flatnonzero(planned.hung).tolist():
                        control.stop(str(robot))
                        stopped[robot] = _return_tick(schedule, robot, tick)
                while report is not None and deaths and report.tick >= deaths[0][0]:
                    await control.replace_world(deaths.pop(0)[1])
                for robot in _needed(stopped, report):
                    del stopped[robot]
                    control.resume(str(robot))
            over = True
        for robot in [robot for robot, tick in stopped.items() if over or tick is None]:
            await control.kill(str(robot))
    finally:
        for robot in stopped:
            control.resume(str(robot))


def _return_tick(schedule: dict[int, ParticipationChange], robot: int, after: int) -> int | None:
    """The tick after `after` at which a robot returns; None if it does not."""
    return next((tick for tick, planned in schedule.items() if tick > after and planned.back[robot]), None)


def _soon(report: Report) -> float:
    """The tick that the world reaches within AHEAD."""
    return report.tick + report.ticks_per_s * AHEAD


def _needed(stopped: dict[int, int | None], report: Report | None) -> list[int]:
    """Those of the `stopped` robots, each with the tick at which it resumes, that the world needs now or soon."""
    waking = {robot: tick for robot, tick in stopped.items() if tick is not None}
    if not waking:
        return []
    soon = _soon(report) if report is not None else min(waking.values())
    return [robot for robot, tick in waking.items() if tick <= soon]
