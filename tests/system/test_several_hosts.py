"""A run over several machines, each a network namespace: routers, sites, a slow link, a cut cable."""

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from console.backends import inprocess
from console.replay import command as replay_command
from console.replay import log
from tests.support import hosts
from tests.support.hosts import Internet
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, alive, command, until

WHY_NOT = hosts.why_not()
pytestmark = pytest.mark.skipif(bool(WHY_NOT), reason=f"many hosts: skipped, because {WHY_NOT}")

SECONDS = 3.0
LISTENING = ["-l", "tcp/0.0.0.0:7447"]

WATCH = """
import asyncio, sys
from console.connect import observer
from fes.transport import bus
from fes.transport.endpoints import Endpoints

async def main(endpoint, tick):
    async with bus.opened(Endpoints("client", (endpoint,))) as opened:
        async for report in observer.reports(opened, "main", 30.0, 30.0):
            if report is not None and report.tick >= tick:
                return

asyncio.run(main(sys.argv[1], int(sys.argv[2])))
"""
"""Command of an observer that ends when a run has reached a tick."""


class Team:
    """A world, and agents of one or several robots, on machines of a network."""

    def __init__(self, where: Path, net: Internet) -> None:
        self.where, self.net = where, net
        self.processes: list[subprocess.Popen[str]] = []

    def world(self, host: str, scenario: str, *words: str) -> None:
        head = [str(CONFIGS / scenario), "--out", "out", "--exit-with-stdin", *words]
        self.processes.append(self.net.start(host, command("world.process", *head), self.where / "world.log"))

    def agent(self, host: str, ids: str, endpoint: str) -> None:
        words = command("agents.process", "--id", ids, "-e", endpoint, "--exit-with-stdin")
        self.processes.append(self.net.start(host, words, self.where / f"agent-{ids}.log"))

    def reaches(self, tick: int, host: str, endpoint: str) -> None:
        """Wait until an observer on a machine sees that the run has reached a tick."""
        watching = self.net.start(host, [sys.executable, "-c", WATCH, endpoint, str(tick)], self.where / "watch.log")
        assert watching.wait(PATIENCE) == 0, self.all_said()

    def ends_well(self, host: str, endpoint: str) -> None:
        """End the run after all robots answered, so that none misses the end; reexecute its log."""
        back = max(map(int, re.findall(r"is back from tick (\d+)", self.said())))
        self.reaches(back + 10, host, endpoint)
        self.processes[0].send_signal(signal.SIGINT)
        result = self.summary()
        assert "robot 0 is absent" not in self.said()
        recorded = log.load(self.where / "out/run.mcap")
        assert replay_command.rerun(recorded, all_robots=True)["digest"] == result["digest"]

    def said(self, who: str = "world") -> str:
        return (self.where / f"{who}.log").read_text()

    def all_said(self) -> str:
        return "".join(path.read_text() for path in sorted(self.where.glob("*.log")))

    def summary(self) -> dict[str, Any]:
        """The summary, once all processes have ended without error."""
        codes = [process.wait(PATIENCE) for process in self.processes]
        assert not any(codes), self.all_said()
        run_summary: dict[str, Any] = json.loads((self.where / "out/summary.json").read_text())
        return run_summary


@pytest.fixture
def net() -> Iterator[Internet]:
    with hosts.internet() as made:
        yield made


@pytest.fixture
def team(tmp_path: Path, net: Internet) -> Team:
    return Team(tmp_path, net)


def digest(scenario: str, seconds: float = SECONDS) -> Any:
    """Digest of the same run in one loop."""
    return inprocess.run(load(scenario, run__duration=seconds), "hosts")["digest"]


def test_one_host_per_robot_with_the_world_as_router_has_the_digest_of_one_loop(team: Team, net: Internet) -> None:
    robots = [f"robot-{robot}" for robot in range(10)]
    net.switch("world", *robots)
    for robot, host in enumerate(robots):
        team.agent(host, str(robot), net.hosts["world"].endpoint())
    team.world("world", "paper.toml", *LISTENING, "--duration", str(SECONDS))
    assert team.summary()["digest"] == digest("paper.toml")
    assert "any process that reaches it can steer robots" in team.said()


def test_a_router_that_is_not_a_world_carries_a_run_to_the_same_digest(team: Team, net: Internet) -> None:
    net.switch("router", "world", "north", "south")
    net.router("router", team.where / "router.log")
    endpoint = net.hosts["router"].endpoint()
    team.world("world", "paper.toml", "-m", "client", "-e", endpoint, "--duration", str(SECONDS))
    for robot in range(10):
        team.agent("north" if robot % 2 else "south", str(robot), endpoint)
    assert team.summary()["digest"] == digest("paper.toml")


def sites(net: Internet, where: Path, *links: tuple[str, str]) -> None:
    """Sites with a router, a world and two machines each; a router reaches those that come before it in `links`."""
    names = sorted({name for link in links for name in link})
    for name in names:
        net.switch(f"{name}-router", f"{name}-world", f"{name}-0", f"{name}-1")
    reached: dict[str, list[str]] = {name: [] for name in names}
    for number, (first, second) in enumerate(links):
        net.cable(f"{first}-router", f"{second}-router")
        reached[second].append(f"tcp/10.77.{len(names) + number}.1:7447")
    for name in names:
        net.router(f"{name}-router", where / f"router-{name}.log", *reached[name])
        until(partial(_ready, where / f"router-{name}.log"))


def _ready(said: Path) -> bool:
    return "ready" in said.read_text()


def spread(team: Team, net: Internet, at: tuple[str, str], seconds: float) -> None:
    """A world in the east, and ten agents at two sites in turn."""
    east = net.hosts["east-router"].endpoint()
    team.world("east-world", "paper.toml", "-m", "client", "-e", east, "--duration", str(seconds))
    for robot in range(10):
        site = at[robot % 2]
        team.agent(f"{site}-{robot // 5}", str(robot), net.hosts[f"{site}-router"].endpoint())


def test_two_sites_with_a_router_each_lose_no_beacon_and_reach_the_same_digest(team: Team, net: Internet) -> None:
    sites(net, team.where, ("east", "west"))
    spread(team, net, ("east", "west"), SECONDS)
    assert team.summary()["digest"] == digest("paper.toml")
    assert "recalled" not in team.all_said()  # one path only: first-in first-out holds from end to end


def test_beacons_on_a_slower_route_than_ticks_are_recalled_and_change_no_digit(team: Team, net: Internet) -> None:
    """Three sites in a ring: beacons between neighbors take a direct route, here a very slow one."""
    seconds = 0.5
    sites(net, team.where, ("east", "west"), ("east", "south"), ("south", "west"))
    slow = ["tc", "qdisc", "add", "dev", "lan5", "root", "tbf", "rate", "60kbit", "burst", "2kb", "latency", "9s"]
    for site in ("south", "west"):
        try:
            net.hosts[f"{site}-router"].run(*slow)
        except OSError as error:
            pytest.skip(f"a slow way: skipped, because this kernel shapes no link: {error}")
    spread(team, net, ("south", "west"), seconds)
    assert team.summary()["digest"] == digest("paper.toml", seconds)
    assert "recalled" in team.all_said()


def test_a_disconnected_robot_is_excluded_until_it_reconnects(team: Team, net: Internet) -> None:
    net.switch("world", "robot-0", "robot-1", "robot-2")
    words = ["--set", "robots.count=3", "--duration", "100000", "--rtf", "1"]
    team.world("world", "hundred.toml", *LISTENING, *words)
    for robot in range(3):
        team.agent(f"robot-{robot}", str(robot), net.hosts["world"].endpoint())
    team.reaches(50, "world", net.hosts["world"].endpoint())
    net.pull("robot-1")
    until(lambda: "robot 1 is absent from tick" in team.said())
    net.plug("robot-1")
    until(lambda: "robot 1 is back from tick" in team.said())
    team.ends_well("world", net.hosts["world"].endpoint())


def test_a_disconnected_site_is_excluded_until_it_reconnects(team: Team, net: Internet) -> None:
    sites(net, team.where, ("east", "west"))
    team.world(
        "east-world", "hundred.toml", "-m", "client", "-e", net.hosts["east-router"].endpoint(),
        "--set", "robots.count=4", "--duration", "100000", "--rtf", "1",
    )  # fmt: skip
    for robot, site in enumerate(("east", "east", "west", "west")):
        team.agent(f"{site}-{robot % 2}", str(robot), net.hosts[f"{site}-router"].endpoint())
    team.reaches(50, "east-world", net.hosts["east-router"].endpoint())
    router = net.hosts["west-router"]
    router.ip("link", "set", "lan2", "down")
    until(lambda: all(f"robot {robot} is absent from tick" in team.said() for robot in (2, 3)))
    router.ip("link", "set", "lan2", "up")
    until(lambda: all(f"robot {robot} is back from tick" in team.said() for robot in (2, 3)))
    team.ends_well("east-world", net.hosts["east-router"].endpoint())


def test_hosts_are_removed_when_their_owner_is_killed(tmp_path: Path) -> None:
    def here() -> str:
        return subprocess.run(["ip", "-o", "link"], check=True, capture_output=True, text=True).stdout

    before = here()
    code = """
import sys, time
from pathlib import Path
from tests.support import hosts
with hosts.internet() as net:
    net.switch("a", "b")
    net.router("a", Path("router.log"))
    while "ready" not in Path("router.log").read_text():
        time.sleep(0.01)
    print(*(host.holder.pid for host in net.hosts.values()), net.started[0].pid, flush=True)
    sys.stdin.read()
"""
    maker = subprocess.Popen(
        [sys.executable, "-c", code], cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert maker.stdout is not None
    pids = [int(pid) for pid in maker.stdout.readline().split()]
    namespaces = {os.readlink(f"/proc/{pid}/ns/net") for pid in pids}
    assert os.readlink("/proc/self/ns/net") not in namespaces
    assert len(namespaces) == 3
    maker.kill()
    maker.communicate(timeout=PATIENCE)
    until(lambda: not any(alive(pid) for pid in pids))
    assert here() == before
