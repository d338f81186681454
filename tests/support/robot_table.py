"""A table with one real `fes-robot` that cruises, and the truth of its travel."""

import asyncio
import itertools
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import tomli_w

from console.backends.process_group import free_port
from console.team import gates, permit
from console.team.robot_tables import robot_tables
from console.team.table_run import free_datagram_port
from fes.protocol import keys
from fes.protocol.robot_control import RUNNING, GateStatus
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from tests.support import proxy
from tests.support.paths import ROOT
from tests.support.processes import PATIENCE, alive, children
from world.config import builtin
from world.config.scenario import load

RUN = keys.DEFAULT_RUN
LINEAR, ACCELERATION = 0.2, 1.0
"""Speed [m/s] and acceleration [m/s^2] of the body, at its own size."""

TRUTH_PERIOD = 0.1
"""Time between two lines of the truth [s]."""

PERIOD = 0.02
"""Period of agent and gate [s]."""

GENEROUS = 3.0
"""Factor on the times of a bound: the test's machine may run other tests beside this one."""


def bound(timeout: float, speed: float = LINEAR) -> float:
    """Longest travel after an event that a gate notices after `timeout` [s], generously [m; of the body].

    A body that holds its last command travels `speed` times the whole wait of the test, and so much farther.
    """
    times = GENEROUS * (timeout + 2 * PERIOD) + 2 * TRUTH_PERIOD
    return speed * speed / (2 * ACCELERATION) + speed * times


class Stage:
    """The processes of a table and of its only robot."""

    def __init__(self, folder: Path, session: Bus, link: proxy.Link) -> None:
        self.folder, self.session, self.link = folder, session, link
        self.table: subprocess.Popen[bytes]
        self.robot: subprocess.Popen[bytes]

    @property
    def gate(self) -> int:
        """The pid of the robot's gate."""
        [pid] = [pid for pid, line in children(self.robot.pid).items() if "field.gate" in line]
        return pid

    def truth(self) -> list[dict[str, Any]]:
        """The lines of the truth so far."""
        lines = (self.folder / "truth.jsonl").read_text().split("\n")[:-1]
        return [json.loads(line) for line in lines]

    async def says(self, words: str) -> None:
        """Wait until robot or gate have logged these words."""
        async with asyncio.timeout(PATIENCE):
            while words not in self.log():
                await asyncio.sleep(0.05)

    def log(self) -> str:
        """The words of robot and gate so far."""
        return (self.folder / "robot.log").read_text()

    async def status(self) -> GateStatus | None:
        """The state of the gate; None if it does not answer."""
        [answer] = (await gates.ask(self.session, keys.gate_status, RUN, [0])).values()
        return answer if isinstance(answer, GateStatus) else None

    async def mode(self, wanted: str, reason: str = "") -> GateStatus:
        """Wait until the gate has a mode, for a reason that contains a text."""
        async with asyncio.timeout(PATIENCE):
            while True:
                status = await self.status()
                if status is not None and status.mode == wanted and reason in status.reason:
                    return status
                await asyncio.sleep(0.05)

    async def cruises(self) -> None:
        """Wait until the body has its full speed."""
        await self._line(lambda line: line["twists"][0][0] > 0.99 * LINEAR)

    async def stands(self, after: float) -> float:
        """Wait until the body stands for half a second; its travel since the time `after` [s; monotonic] [m]."""
        still = [0]

        def is_still(line: dict[str, Any]) -> bool:
            still[0] = still[0] + 1 if line["monotonic"] > after and abs(line["twists"][0][0]) < 1e-6 else 0
            return still[0] >= 5

        await self._line(is_still)
        return self.travel(after)

    def travel(self, after: float, scale: float = 100.0) -> float:
        """The path of the body since a time, from the last line before it [m; of the body]."""
        lines = self.truth()
        begin = max((place for place, line in enumerate(lines) if line["monotonic"] <= after), default=0)
        path = [line["poses"][0] for line in lines[begin:]]
        steps = itertools.pairwise(path)
        return sum(float(((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5) for a, b in steps) / scale

    async def _line(self, fits: Callable[[dict[str, Any]], bool]) -> None:
        """Wait for a line of the truth that fits; each is looked at once."""
        seen = len(self.truth())
        async with asyncio.timeout(PATIENCE):
            while True:
                lines = self.truth()
                fitting = [line for line in lines[seen:] if fits(line)]
                if fitting:
                    return
                seen = len(lines)
                await asyncio.sleep(TRUTH_PERIOD)


@asynccontextmanager
async def stage(
    folder: Path,
    change: Callable[[dict[str, Any]], None] = lambda tables: None,
    environment: Mapping[str, str] | None = None,
    **table: Any,
) -> AsyncIterator[Stage]:
    """A table and a robot that is ready, and stands; its gate reaches its driver over `Stage.link`.

    `change` edits the tables of robot.toml, `environment` is added to that of both processes, and `table` overrides
    fields of [tabletop].
    """
    variables = {**os.environ, **(environment or {})}
    endpoint, radio = f"tcp/127.0.0.1:{free_port()}", f"127.0.0.1:{free_datagram_port()}"
    overrides = {f"tabletop.{name}": value for name, value in table.items()}
    alone = {"robots.poses": [[0.0, 0.0, 0.0]], **overrides}
    scenario = load(builtin.resolve(Path("tabletop")), alone)
    tables = robot_tables(scenario, RUN, endpoint, radio)
    tables["limits"] |= {"command_timeout": 0.25, "command_age": 0.1, "pose_age": 0.2, "lateness": 0.5}
    tables["controller"] = "tests.support.cruise:Cruise"
    sets = [word for name, value in alone.items() for word in ("--set", f"{name}={json.dumps(value)}")]
    words = ["world.tabletop", "tabletop", "-l", endpoint, "--radio", radio, "--truth", str(folder / "truth.jsonl")]
    robot = ["field", str(folder / "robot.toml"), "--id", "0", "--out", str(folder), "--use", "tests.support.cruise"]
    started: list[subprocess.Popen[bytes]] = []
    try:
        started.append(_start(folder / "table.log", variables, *words, *sets))
        connected = bus.opened(Endpoints("client", (endpoint,), timeout=PATIENCE))
        async with connected as session, proxy.link(endpoint) as link:
            on = Stage(folder, session, link)
            on.table = started[0]
            tables["body"]["endpoint"] = link.endpoint
            change(tables)
            (folder / "robot.toml").write_text(tomli_w.dumps(tables))
            ready = asyncio.Event()
            session.declare_liveliness_subscriber(keys.gate_alive(RUN, 0), lambda key, alive: ready.set())
            started.append(_start(folder / "robot.log", variables, *robot))
            on.robot = started[1]
            try:
                await asyncio.wait_for(ready.wait(), PATIENCE)
            except TimeoutError:
                raise AssertionError(on.log()) from None
            yield on
    finally:
        for process in reversed(started):
            end(process)


def _start(log: Path, variables: Mapping[str, str], *words: str) -> "subprocess.Popen[bytes]":
    command = [sys.executable, "-m", *words]
    with log.open("wb") as out:
        return subprocess.Popen(command, cwd=ROOT, env=variables, stdin=subprocess.DEVNULL, stdout=out, stderr=out)


def end(process: "subprocess.Popen[bytes]") -> None:
    """Kill a process and its children."""
    pids = [process.pid, *children(process.pid)]
    for pid in pids:
        if alive(pid):
            os.kill(pid, signal.SIGKILL)
    process.wait()


def run(main: Callable[[], Awaitable[None]]) -> None:
    """Run a test's coroutine."""

    async def bounded() -> None:
        async with asyncio.timeout(2 * PATIENCE):
            await main()

    asyncio.run(bounded())


def now() -> float:
    """The clock of the truth [s; monotonic]."""
    return time.monotonic()


@asynccontextmanager
async def moving(on: Stage) -> AsyncIterator[None]:
    """A robot that cruises while an operator holds its permit."""
    async with permit.held(on.session, RUN):
        assert gates.is_started((await gates.start(on.session, RUN, [0]))[0])
        await is_running(on)
        yield


async def is_running(on: Stage) -> None:
    """Wait until the gate passes commands, and the body has its full speed."""
    await on.mode(RUNNING)
    await on.cruises()


async def ended(pid: int) -> None:
    """Wait until a process has ended."""
    async with asyncio.timeout(PATIENCE):
        while alive(pid):
            await asyncio.sleep(0.05)
