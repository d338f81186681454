"""A router with certificates, two `fes-robot` behind it on a simulated table, and visitors with any certificate."""

import asyncio
import json
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import tomli_w

from console.backends.process_group import free_port
from console.keys import certificates
from console.team.robot_tables import robot_tables
from console.team.table_run import free_datagram_port
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from tests.support import team_keys
from tests.support.processes import PATIENCE, command, fes, until
from tests.support.robot_table import end
from world.config import builtin
from world.config.scenario import load

RUN = "lab"
ROLES = ["world", "robot-0", "robot-1", "observer", "operator"]
POSES = [[0.0, 0.0, 0.0], [60.0, 0.0, 0.0]]


class Team:
    """The processes of the team."""

    def __init__(self, folder: Path, issuer: certificates.Authority) -> None:
        self.folder = folder
        self.keys = team_keys.directory(folder / "keys", issuer, ROLES)
        self.endpoint = f"tls/127.0.0.1:{free_port()}"
        self.running: list[subprocess.Popen[bytes]] = []

    def start(self, name: str, words: list[str]) -> "subprocess.Popen[bytes]":
        """Start a process that logs to a file of this name."""
        with (self.folder / f"{name}.log").open("wb") as out:
            started = subprocess.Popen(words, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=out, stderr=out)
        self.running.append(started)
        return started

    def robot(self, name: str, robot: int, keys: Path | None = None) -> "subprocess.Popen[bytes]":
        """Start `fes-robot` for this robot, with the team's certificates or those of another folder."""
        file, used = str(self.folder / "robot.toml"), ["--use", "tests.support.cruise"]
        words = [file, "--id", str(robot), "--keys", str(keys or self.keys), "--timeout", f"{PATIENCE:g}", *used]
        return self.start(name, command("field.process", *words))

    def log(self, name: str) -> str:
        """The words of a process so far."""
        return (self.folder / f"{name}.log").read_text()

    async def logs(self, name: str, words: str) -> None:
        """Wait until a process has logged these words."""
        await asyncio.to_thread(until, lambda: words in self.log(name))

    async def person(self, *words: str) -> "subprocess.CompletedProcess[str]":
        """The outcome of a command of a person on this network."""
        line = fes("team", *words, "--run", RUN, "-e", self.endpoint, "--keys", str(self.keys))
        call = dict[str, Any](cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
        return await asyncio.to_thread(lambda: subprocess.run(line, check=False, **call))

    def speed(self, robot: int) -> float:
        """The present speed of a body, from the truth [m/s; of the body]."""
        lines = (self.folder / "truth.jsonl").read_text().split("\n")[:-1]
        return abs(float(json.loads(lines[-1])["twists"][robot][0])) if lines else 0.0

    @asynccontextmanager
    async def visitor(self, role: str) -> AsyncIterator[Bus]:
        """A session with the certificate of a role."""
        own = team_keys.security(self.keys, role)
        async with bus.opened(Endpoints("client", (self.endpoint,), timeout=PATIENCE, security=own)) as opened:
            yield opened


@asynccontextmanager
async def team(folder: Path) -> AsyncIterator[Team]:
    """A router with certificates, and two robots that are ready and stand; both cruise when they are started."""
    on = Team(folder, certificates.create(1.0))
    try:
        on.start("router", fes("team", "router", "-l", on.endpoint, "--run", RUN, "--keys", str(on.keys)))
        await on.logs("router", "ready")
        _table(on)
        for robot in range(2):
            on.robot(f"robot-{robot}", robot)
        for robot in range(2):
            await on.logs(f"robot-{robot}", "ready: run")
        yield on
    finally:
        for process in reversed(on.running):
            end(process)


def _table(on: Team) -> None:
    """Start the bodies, and write robot.toml: the driver is local and without TLS, the team's network is not."""
    near, radio = f"tcp/127.0.0.1:{free_port()}", f"127.0.0.1:{free_datagram_port()}"
    tables = robot_tables(load(builtin.resolve(Path("tabletop")), {"robots.poses": POSES}), RUN, near, radio)
    tables["limits"] |= {"lateness": 2.0, "command_age": 1.0, "command_timeout": 2.0, "pose_age": 2.0}
    tables["limits"] |= {"permit_timeout": 5.0, "motion_check": 0.0}
    tables["controller"] = "tests.support.cruise:Cruise"
    tables["team"] = {"endpoint": on.endpoint}
    (on.folder / "robot.toml").write_text(tomli_w.dumps(tables))
    words = ["tabletop", "-l", near, "--radio", radio, "--truth", str(on.folder / "truth.jsonl")]
    on.start("table", command("world.tabletop.process", *words, "--set", f"robots.poses={json.dumps(POSES)}"))
