"""Robots that hang by schedule: their processes are suspended, delay no other, resume in time, and end."""

import asyncio
import json
import os
import signal
import subprocess
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from console.backends import fault_injection, inprocess
from fes.protocol.report import Report
from tests.support.frames import a_report
from tests.support.loop import load
from tests.support.processes import PATIENCE, STARTING, alive, children, fes, start, until
from world.config.scenario import Scenario
from world.metrics.summary import write_scenario

HANG = {"at": 2.0, "hang": [4, 6]}
LATER = {"at": 6.0, "hang": [4, 6]}
"""A hang after a run that began slowly has caught up; earlier, it may reach the end of a hang within a second."""


def state(pid: int) -> str:
    """State of a process: R, S, T (stopped), Z, ...; X after its end."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except OSError:
        return "X"


class Watched:
    """A run in processes, and the pids of its agents."""

    def __init__(self, where: Path, scenario: Scenario, pace: float) -> None:
        write_scenario(where, scenario)
        words = ["run", "scenario.toml", "--headless", "--json", "--rtf", f"{pace:g}", "--out", "out"]
        self.where, self.running = where, start(fes(*words), where)
        self.agents: list[int] = []
        self.robots = scenario.robots.number

    def agent(self, robot: int) -> int:
        """Pid of a robot's agent, as soon as it runs."""

        def found() -> list[int]:
            words = f"-m agents --id {robot} "
            return [pid for pid, line in children(self.running.pid).items() if words in line]

        until(found)
        self.agents += found()
        return self.agents[-1]

    def outcome(self) -> dict[str, Any]:
        output, complained = self.running.communicate(timeout=PATIENCE)
        assert (self.running.returncode, complained) == (0, STARTING.format(self.robots))
        result: dict[str, Any] = json.loads(output)
        return result

    def log(self, robot: int) -> str:
        return (self.where / f"out/agent-{robot}.log").read_text()

    def end(self) -> None:
        """End all processes, also after a failed test."""
        if self.running.poll() is None:
            self.running.kill()
        self.running.communicate()
        for pid in self.agents:
            if alive(pid):
                os.kill(pid, signal.SIGKILL)


Watch = Callable[[Scenario, float], Watched]


@pytest.fixture
def watch(tmp_path: Path) -> Iterator[Watch]:
    begun: list[Watched] = []

    def begin(scenario: Scenario, pace: float) -> Watched:
        begun.append(Watched(tmp_path, scenario, pace))
        return begun[-1]

    yield begin
    for process in begun:
        process.end()


@pytest.mark.parametrize("wake", [14.0, 26.0], ids=["briefly", "longer than its lease"])
def test_fes_run_suspends_and_continues_processes_as_scheduled_and_the_digest_is_the_same(
    wake: float, watch: Watch
) -> None:
    events = [LATER, {"at": wake, "wake": [4]}, {"at": wake + 1.0, "wake": [6]}]
    scenario = load("neighborhood.toml", run__duration=wake + 3.0, event=events)
    watched = watch(scenario, 4.0)
    pids = {robot: watched.agent(robot) for robot in (4, 5, 6)}
    until(lambda: state(pids[4]) == state(pids[6]) == "T")
    assert state(pids[5]) != "T"
    until(lambda: state(pids[4]) != "T" and state(pids[6]) != "T")
    assert watched.outcome()["digest"] == inprocess.run(scenario, "scenario")["digest"]
    for robot in (4, 5, 6):  # the same process resumes
        assert watched.log(robot).count("ready") == watched.log(robot).count("the run is over") == 1
        assert "dropped" not in watched.log(robot)
    world = (watched.where / "out/world.log").read_text()
    assert "starts" in world
    assert not any(words in world for words in ("is absent", "does not answer", "dropped"))


def test_robots_that_hang_to_the_end_do_not_delay_it(watch: Watch) -> None:
    scenario = load("neighborhood.toml", run__duration=12.0, event=[HANG])
    watched = watch(scenario, 4.0)
    pids = [watched.agent(robot) for robot in (4, 6)]
    until(lambda: all(state(pid) == "T" for pid in pids))
    assert watched.outcome()["digest"] == inprocess.run(scenario, "scenario")["digest"]
    assert not any(alive(pid) for pid in pids)
    for robot in (4, 6):  # killed while suspended, and not resumed without its world
        assert watched.log(robot).splitlines()[-1].endswith("ready")


def test_a_world_whose_robots_all_hang_continues_and_they_rejoin(watch: Watch) -> None:
    events = [{"at": 1.0, "hang": [0, 1]}, {"at": 25.0, "wake": [0, 1]}]
    scenario = load("pair.toml", run__duration=26.0, event=events)
    watched = watch(scenario, 4.0)
    pids = [watched.agent(robot) for robot in (0, 1)]
    until(lambda: all(state(pid) == "T" for pid in pids))
    assert watched.outcome()["digest"] == inprocess.run(scenario, "scenario")["digest"]


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT], ids=lambda how: how.name)
def test_no_process_outlives_a_launcher_that_ends_while_a_robot_hangs(how: signal.Signals, watch: Watch) -> None:
    watched = watch(load("pair.toml", run__duration=1e5, event=[{"at": 0.5, "hang": [1]}]), 1.0)
    pids = [watched.agent(robot) for robot in (0, 1)]
    until(lambda: state(pids[1]) == "T")
    everybody = list(children(watched.running.pid))
    assert set(pids) <= set(everybody)
    os.kill(watched.running.pid, how)
    watched.running.communicate(timeout=PATIENCE)
    until(lambda: not any(alive(pid) for pid in everybody))


def test_a_crew_of_several_robots_is_not_stopped(tmp_path: Path) -> None:
    scenario = load("neighborhood.toml", run__duration=6.0, event=[HANG, {"at": 4.0, "wake": [4, 6]}])
    write_scenario(tmp_path, scenario)
    words = ["run", "scenario.toml", "--headless", "--json", "--agents-per-process", "5", "--out", "out"]
    done = subprocess.run(fes(*words), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stderr) == (0, "starting a world and 10 robots in 2 processes ...\n")
    assert json.loads(done.stdout)["digest"] == inprocess.run(scenario, "scenario")["digest"]


@pytest.mark.parametrize(("restart", "done"), [(2.4, []), (10.0, ["kill 4", "start 4"])], ids=["brief", "long"])
def test_a_robot_that_may_have_resumed_keeps_its_process(
    monkeypatch: pytest.MonkeyPatch, restart: float, done: list[str]
) -> None:
    """Ten reports per second are of past ticks: a world at full speed is far ahead."""
    scenario = load("paper.toml", event=[{"at": 2.0, "kill": [4]}, {"at": restart, "restart": [4]}])
    did: list[str] = []

    async def reports(*words: Any) -> AsyncIterator[Report]:
        for tick in (90, 125):
            yield a_report([(0.0, 0.0)], tick=tick, ticks_per_s=300.0)

    async def kill(ids: str) -> None:
        did.append(f"kill {ids}")

    async def start(ids: str) -> None:
        did.append(f"start {ids}")

    monkeypatch.setattr("console.connect.observer.reports", reports)
    control = fault_injection.ProcessControl(kill, start, did.append, did.append, lambda seconds: kill("the world"))
    asyncio.run(fault_injection.enact(None, "test", 1.0, scenario, control, alone=True))  # type: ignore[arg-type]
    assert did == done
