"""Agents that die, hang and rejoin a running run, over Zenoh; the log can be executed again."""

import asyncio
import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from agents.process import Agent
from agents.runtime.outbox import Outbox
from console.backends import inprocess
from console.replay import command as replay_command
from console.replay import log
from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE, STARTING, fes
from tests.support.rejoining import live_through, standing_still, until
from world.execution.recorder import Recorder
from world.metrics.summary import write_scenario
from world.server.server import Server

DEADS: list[dict[str, Any]] = [{"at": 0.6, "kill": [4, 6]}, {"at": 1.2, "restart": [4]}, {"at": 1.6, "restart": [6]}]


def test_a_dead_robot_stands_still_rejoins_as_a_new_process_and_its_run_can_be_reexecuted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for patience in ("ANSWER_TIMEOUT", "RESEND_AFTER"):  # only its token informs the barrier
        monkeypatch.setattr(f"world.execution.barrier.{patience}", 1e6)
    dying, say, unsaid = asyncio.Event(), Outbox.publish, list[int]()
    monkeypatch.setattr(
        Outbox,
        "publish",
        lambda *message: unsaid.append(message[1]) if dying.is_set() and message[2][0][0] == 4 else say(*message),
    )
    seen: dict[str, Any] = {}

    async def story(server: Server, agents: list["asyncio.Task[Agent]"], endpoint: str) -> None:
        await until(server, lambda state: state.tick >= 40)
        dying.set()  # just before its answer, for which all wait
        await until(server, lambda state: unsaid)
        dying.clear()
        agents[4].cancel()
        gone = await until(server, lambda state: not state.present[4])
        pose = server.run.state.poses[4].tolist()
        await until(server, lambda state: state.tick >= gone + 60)
        seen["stood"] = server.run.state.poses[4].tolist() == pose
        async with standing_still(server):
            agents[4] = asyncio.ensure_future(session.live(endpoint, [4]))
            while not server.lifecycle.hosting.hosted[4]:
                await asyncio.sleep(0.01)
        back = await until(server, lambda state: state.present[4])
        await until(server, lambda state: state.tick >= back + 30)
        seen["moved"] = server.run.state.poses[4].tolist() != pose
        seen["ticks"] = gone, back

    scenario = load("neighborhood.toml", run__duration=6.0)
    summary = live_through(scenario, tmp_path / "run.mcap", story)
    assert seen["stood"]
    assert seen["moved"]
    assert seen["ticks"][1] > seen["ticks"][0] + 60
    assert summary["ticks"] == 300
    loaded = log.load(tmp_path / "run.mcap")
    again = replay_command.rerun(loaded, all_robots=True)
    absent = sum(not tick.payloads.commands[4] for tick in loaded.ticks())
    assert summary["unscheduled_absences"] == again["unscheduled_absences"] == absent > 60
    assert again["digest"] == summary["digest"] != inprocess.run(scenario, "test")["digest"]
    assert replay_command.rerun_robot(loaded, 4) == 300


def test_a_hung_robot_is_excluded_after_the_deadline_and_rejoins_when_it_answers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asleep, say = asyncio.Event(), Outbox.publish
    delayed: list[tuple[Outbox, int, Any]] = []

    def sleepy(outbox: Outbox, tick: int, answers: Any) -> None:
        if asleep.is_set() and answers[0][0] == 1:
            delayed.append((outbox, tick, answers))
        else:
            say(outbox, tick, answers)

    repeat = Outbox.resend
    monkeypatch.setattr(Outbox, "publish", sleepy)
    monkeypatch.setattr(Outbox, "resend", lambda *asked: None if asleep.is_set() else repeat(*asked))
    seen = []

    async def story(server: Server, agents: Any, endpoint: str) -> None:
        await until(server, lambda state: state.tick >= 20)
        asleep.set()
        with monkeypatch.context() as impatient:
            impatient.setattr("world.execution.barrier.ANSWER_TIMEOUT", 1.0)
            seen.append(await until(server, lambda state: not state.present[1]))
        await until(server, lambda state: state.tick >= seen[0] + 40)
        async with standing_still(server):
            asleep.clear()
            for late in delayed:
                say(*late)
            while not (server._inbox._items or server.lifecycle.reachable[1]):
                await asyncio.sleep(0.01)
        seen.append(await until(server, lambda state: state.present[1]))

    summary = live_through(load("pair.toml", run__duration=4.0), tmp_path / "run.mcap", story)
    assert seen[1] >= seen[0] + 40
    assert len(delayed) == 1
    assert summary["ticks"] == 200
    assert replay_command.rerun(log.load(tmp_path / "run.mcap"), all_robots=True)["digest"] == summary["digest"]


@pytest.mark.parametrize(
    "groups", [[[i] for i in range(10)], [[3, 4, 5], [0, 1, 2, 6, 7, 8, 9]]], ids=["one", "many"]
)
@pytest.mark.parametrize("name", ["paper.toml", "measured.toml"])
def test_scheduled_deaths_have_one_digest_in_one_loop_and_over_zenoh(name: str, groups: list[list[int]]) -> None:
    dying = load(name, run__duration=2.4, event=DEADS)

    async def bounded() -> Any:
        async with asyncio.timeout(60.0):
            return await session.run(dying, groups)

    summary, server, _ = asyncio.run(bounded())
    assert summary["digest"] == inprocess.run(dying, "test")["digest"]
    assert summary["unscheduled_absences"] == 0
    assert not server.drops.counts


def test_late_answers_of_a_scheduled_dead_robot_are_accepted_after_it_rejoins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    delayed, say = [], Outbox.publish

    def slow(outbox: Outbox, tick: int, answers: Any) -> None:
        if (
            answers[0][0] == 6 and 70 <= tick < 80
        ):  # the world does not wait for these; the robot takes part from tick 80 on
            delayed.append((outbox, tick, answers))
            return
        while answers[0][0] == 6 and delayed:
            say(*delayed.pop(0))
        say(outbox, tick, answers)

    monkeypatch.setattr(Outbox, "publish", slow)
    dying = load("paper.toml", run__duration=2.4, event=DEADS)

    async def bounded() -> Any:
        async with asyncio.timeout(60.0):
            return await session.run(dying, [[i] for i in range(10)])

    summary, server, _ = asyncio.run(bounded())
    assert summary["digest"] == inprocess.run(dying, "test")["digest"]
    assert not server.drops.counts


def test_a_log_of_scheduled_deaths_in_one_loop_can_be_reexecuted(tmp_path: Path) -> None:
    dying = load("measured.toml", run__duration=2.4, event=DEADS)
    with Recorder(tmp_path / "run.mcap", dying, "test", "inprocess") as recorder:
        summary = inprocess.run(dying, "test", recorder=recorder)
    loaded = log.load(tmp_path / "run.mcap")
    assert replay_command.rerun(loaded, all_robots=True)["digest"] == summary["digest"]
    assert [replay_command.rerun_robot(loaded, robot) for robot in (4, 5)] == [120, 120]


def test_fes_run_kills_processes_as_scheduled_and_the_digest_is_the_same(tmp_path: Path) -> None:
    # Late and long: a robot that is due within a second, as the run catches up with its pace, keeps its process.
    dying = [{"at": 6.0, "kill": [4, 6]}, {"at": 18.0, "restart": [4]}]
    scenario = load("neighborhood.toml", run__duration=20.0, event=dying)
    write_scenario(tmp_path, scenario)
    words = ["run", "scenario.toml", "--headless", "--json", "--rtf", "4", "--out", "out"]
    done = subprocess.run(fes(*words), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stderr) == (0, STARTING.format(10))
    assert json.loads(done.stdout)["digest"] == inprocess.run(scenario, "scenario")["digest"]
    logs = {robot: (tmp_path / f"out/agent-{robot}.log").read_text() for robot in (4, 5, 6)}
    assert [logs[robot].count("ready") for robot in (4, 5, 6)] == [2, 1, 1]
    assert ["the run is over" in logs[robot] for robot in (4, 5, 6)] == [True, True, False]


def test_a_team_that_hangs_as_one_rejoins_when_it_answers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All that the world can then wait for are hung robots."""
    asleep, say, repeat = asyncio.Event(), Outbox.publish, Outbox.resend
    delayed: list[tuple[Outbox, int, Any]] = []
    monkeypatch.setattr(
        Outbox, "publish", lambda *message: delayed.append(message) if asleep.is_set() else say(*message)
    )
    monkeypatch.setattr(Outbox, "resend", lambda *asked: None if asleep.is_set() else repeat(*asked))

    async def story(server: Server, agents: Any, endpoint: str) -> None:
        await until(server, lambda state: state.tick >= 20)
        asleep.set()
        with monkeypatch.context() as impatient:
            impatient.setattr("world.execution.barrier.ANSWER_TIMEOUT", 0.3)
            await until(server, lambda state: not state.present.any())
        asleep.clear()
        for late in delayed:
            say(*late)

    summary = live_through(load("pair.toml", run__duration=2.0), tmp_path / "run.mcap", story)
    assert len(delayed) == 2
    assert summary["ticks"] == 100
    assert replay_command.rerun(log.load(tmp_path / "run.mcap"), all_robots=True)["digest"] == summary["digest"]
