"""fes team run: a team on a table, with a process fes-robot and a gate for each robot.

Bodies, drivers and radio are those of fes-tabletop; all else is as on real robots.
"""

import asyncio
import contextlib
import os
import socket
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from pathlib import Path
from signal import SIGTERM
from typing import Any

import tomli_w

from console.backends import managed_process
from console.backends.managed_process import ManagedProcess
from console.backends.process_group import free_port
from console.connect import run_directory
from console.connect.run_directory import Address
from console.dashboard import live
from console.doctor.network import spans
from console.team import gates, observer, permit
from console.team.merge import Team
from console.team.recorder import TeamRecorder
from console.team.robot_tables import robot_tables
from console.team.table_result import TableResult, read_truth
from console.terminal import counting
from console.terminal.counting import Watch
from fes.errors import FesError, Unavailable
from fes.extension import crew_laws, registry
from fes.protocol import keys
from fes.protocol.report import Report
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from world.config.scenario import Scenario
from world.metrics import summary
from world.metrics.optimum import optimal_separation

PATIENCE = 60.0
"""Longest time until all gates are ready [s]: a process takes a second of a processor to start."""

PAUSE = 0.2
"""Time between two looks for the gates [s]."""

SETTLING = 6.0
"""Time between the last gate and the start of the robots [s]: the processes that write their logs start meanwhile."""

ENDING = 10.0
"""Longest time for a process to end [s]; then it is killed."""

TRUTH, ROBOTS, RECORD = "truth.jsonl", "robot.toml", "team"
"""Names in the run directory."""

Show = Callable[[str], None]


class TableRun:
    """A team on a table, in a run directory."""

    def __init__(self, scenario: Scenario, directory: Path, say: Show) -> None:
        """The directory holds scenario.toml; `say` shows one line to a person."""
        self._scenario, self._directory, self._say = scenario, directory, say
        self._endpoint = f"tcp/127.0.0.1:{free_port()}"
        self._children: list[ManagedProcess] = []
        self._team = Team(keys.DEFAULT_RUN, range(scenario.robots.number))
        self._result = TableResult(
            optimal_separation(scenario.objective, scenario.channel), crew_laws.physical_period(scenario.seeking)
        )

    async def run(self, frames: live.Screen | None, watch: Watch = counting.ignore) -> dict[str, Any]:
        """Run the team for the scenario's duration; returns the summary. Raises FesError.

        `watch` is called with the ticks since the start, by the wall clock.
        """
        robots = list(range(self._scenario.robots.number))
        try:
            await self._start(robots)
            async with contextlib.AsyncExitStack() as stack:
                session = await self._while_all_run(self._prepared(stack, robots))
                run_directory.announce(self._directory, Address(self._endpoint, keys.DEFAULT_RUN, os.getpid()))
                started = await self._move(session, robots, frames, watch)
        finally:
            run_directory.withdraw(self._directory)
            await self._end()
        return {
            "clock": summary.ROBOTS,
            "robots": len(robots),
            **self._result.summary(started, read_truth(self._directory / TRUTH)),
            "beacons": dict(self._team.totals()),
        }

    async def _start(self, robots: list[int]) -> None:
        """Start the table and the robots; raises FesError."""
        radio = f"127.0.0.1:{free_datagram_port()}"
        tables = robot_tables(self._scenario, keys.DEFAULT_RUN, self._endpoint, radio)
        file = self._directory / ROBOTS
        file.write_text(tomli_w.dumps(tables), encoding="utf-8")
        used = [word for module in registry.used() for word in ("--use", module)]
        table = [str(self._directory / "scenario.toml"), "-l", self._endpoint, "--radio", radio]
        table += ["--truth", str(self._directory / TRUTH), *used]
        await self._child("fes-tabletop", "world.tabletop", table, "tabletop.log")
        for robot in robots:
            words = [
                str(file),
                "--id",
                str(robot),
                "--out",
                str(self._directory),
                "--timeout",
                f"{PATIENCE:g}",
            ]
            await self._child(f"fes-robot {robot}", "field", [*words, *used], f"robot-{robot}.log")

    async def _child(self, name: str, module: str, arguments: list[str], log: str) -> None:
        self._children.append(await managed_process.start(name, module, arguments, self._directory / log))

    async def _prepared(self, stack: contextlib.AsyncExitStack, robots: list[int]) -> Bus:
        """A session of the team, whose robots are ready; the stack closes it. Raises FesError."""
        opening = bus.opened(Endpoints("client", (self._endpoint,), timeout=PATIENCE))
        session = await stack.enter_async_context(opening)
        await self._ready(session, robots)
        await asyncio.sleep(SETTLING)
        return session

    async def _while_all_run(self, work: Coroutine[Any, Any, Bus]) -> Bus:
        """The result of `work`; raises FesError as soon as a process of the team ends."""
        task, watch = asyncio.create_task(work), asyncio.create_task(self._watch())
        try:
            await asyncio.wait((task, watch), return_when=asyncio.FIRST_COMPLETED)
            if watch.done():
                watch.result()
            return await task
        finally:
            task.cancel()
            watch.cancel()
            await asyncio.gather(task, watch, return_exceptions=True)

    async def _ready(self, session: Bus, robots: list[int]) -> None:
        """Wait until the gates and agents of all robots are alive; raises FesError."""
        end = time.monotonic() + PATIENCE
        present: set[int] = set()
        while len(present) < len(robots):
            if time.monotonic() > end:
                absent = spans(sorted(set(robots) - present))
                raise Unavailable(f"robots {absent} were not ready within {PATIENCE:g} s")
            await asyncio.sleep(PAUSE)
            with contextlib.suppress(Unavailable):
                tokens = await session.liveliness_get(keys.robot_alive(keys.DEFAULT_RUN, "*"), gates.PATIENCE)
                present = {robot for key in tokens if (robot := keys.robot_of(key)) is not None}
                present &= set(await gates.present(session, keys.DEFAULT_RUN))

    async def _move(self, session: Bus, robots: list[int], frames: live.Screen | None, watch: Watch) -> float:
        """Hold the permit for the scenario's duration, and collect the reports; returns the monotonic start."""
        team, name = self._team, keys.DEFAULT_RUN
        with TeamRecorder(self._directory / RECORD, team) as recorder:
            reports = self._collected(observer.reports(session, name, PATIENCE, team), team, recorder, frames)
            tasks = [
                asyncio.create_task(permit.start_and_hold(session, name, robots, self._say), name="permit"),
                asyncio.create_task(_follow(reports, frames), name="reports"),
                asyncio.create_task(self._watch(watch), name="children"),
            ]
            started = time.monotonic()
            try:
                await asyncio.wait(tasks, timeout=self._scenario.run.duration, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for task in tasks:
                    if not task.done():
                        task.cancel()
                results = await asyncio.gather(*tasks, return_exceptions=True)
        for result in results:
            if isinstance(result, FesError):
                raise result
        if results[0] is not True:
            raise FesError("a robot did not start, or has not confirmed its stop")
        return started

    async def _collected(
        self,
        reports: AsyncIterator[Report | None],
        team: Team,
        recorder: TeamRecorder,
        frames: live.Screen | None,
    ) -> AsyncIterator[Report | None]:
        """The reports, after each was recorded."""
        loop = asyncio.get_running_loop()
        async for report in reports:
            if report is not None:
                self._result.add(report, time.monotonic())
                recorder.add(report)
                if frames is not None:
                    frames.history.modes = team.modes(loop.time())
            yield report

    async def _watch(self, watch: Watch = counting.ignore) -> None:
        """Count ticks, and raise FesError as soon as a process of the team ends."""
        started = time.monotonic()
        while True:
            for child in self._children:
                if not child.runs:
                    raise FesError(child.verdict())
            watch(int((time.monotonic() - started) / self._scenario.run.dt))
            await asyncio.sleep(PAUSE)

    async def _end(self) -> None:
        """End all processes: first the robots, whose gates stop the bodies."""
        for children in (self._children[1:], self._children[:1]):
            for child in children:
                child.signal(SIGTERM)
            if not await managed_process.ended(children, ENDING):
                for child in children:
                    with contextlib.suppress(ProcessLookupError):
                        child.process.kill()


async def _follow(reports: AsyncIterator[Report | None], frames: live.Screen | None) -> None:
    """Show the reports, or only consume them."""
    if frames is not None:
        await live.follow(reports, frames)
        return
    async for _ in reports:
        pass


def free_datagram_port() -> int:
    """A free UDP port of the loopback interface."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
