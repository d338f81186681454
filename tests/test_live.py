"""The live clock: nobody is waited for, and what comes late is counted and held."""

import asyncio
import json
import logging
import signal
import subprocess
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.mouth import Mouth
from agents.presence import Presence
from agents.turns import Turns
from console import header, log, replay
from console.launcher import free_port
from fes import keys, messages
from fes.complaints import Complaints
from fes.errors import FesError
from fes.inbox import Inbox
from fes.messages import Command, Observation
from tests import session
from tests.frames import a_report
from tests.loop import CONFIGS, load
from tests.test_processes import PATIENCE, fes, start
from tests.test_processes import command as command_line
from world import live, simulation
from world.course import Course
from world.deadlines import COMMAND_TIMEOUT, Deadlines, none
from world.live import WARM_UP, Held
from world.recorder import Recorder
from world.scenario import Scenario
from world.server import Server
from world.simulation import State

NOTHING = np.zeros(0, dtype=np.int64)
TICK = 0.02  # s


def command(robot: int, tick: int, speed: float = 1.0) -> bytes:
    return messages.encode_command(Command(tick, robot, (speed, 0.0), NOTHING, np.zeros(0), np.zeros(0)))


class Everybody:
    """An attendance that notes what it is told."""

    def __init__(self) -> None:
        self.silent: list[list[int]] = []
        self.heard: list[int] = []

    def hang(self, silent: Any) -> None:
        self.silent.append(np.flatnonzero(silent).tolist())

    def woke(self, robot: int) -> bool:
        self.heard.append(robot)
        return False


def world_of_two() -> tuple[State, Deadlines, Everybody]:
    world = simulation.create(load("pair.toml", run__clock="live"))
    return simulation.start(world), none(2), Everybody()


def spoken(said: dict[int, list[bytes]], ticks: int) -> tuple[list[list[int]], Deadlines, Everybody]:
    """For each tick the tick of the command that each of two robots follows, -1 for none; `said` by tick."""
    state, deadlines, everybody = world_of_two()
    found: list[list[int]] = []

    async def main() -> None:
        inbox = Inbox(asyncio.get_running_loop())
        held = Held(inbox, everybody, Complaints(logging.getLogger("test")), deadlines, 1e-4)  # type: ignore[arg-type]
        held._dt = TICK
        held._end_of_tick = lambda: asyncio.sleep(0)  # type: ignore[method-assign]
        for tick in range(ticks):
            for payload in said.get(tick, []):
                inbox.put(keys.command("test", messages.decode_command(payload).robot), payload)
            now = replace(state, tick=tick)
            answers = await held.collect(now, [b"", b""])
            ticks_of = np.array([answer[0].tick if answer else -1 for answer in answers])
            deadlines.add(tick, now.present, ticks_of)
            found.append(ticks_of.tolist())

    asyncio.run(main())
    return found, deadlines, everybody


def test_the_last_command_is_held_until_it_is_too_old_and_then_the_robot_stops() -> None:
    ticks = 40
    always = {tick: [command(0, tick)] for tick in range(ticks)}
    always[0].append(command(1, 0))
    found, deadlines, everybody = spoken(always, ticks)
    alive = round(COMMAND_TIMEOUT / TICK + 0.4999)  # ticks for which a command holds
    assert [robots[0] for robots in found] == list(range(ticks))
    assert [robots[1] for robots in found] == [0] * alive + [-1] * (ticks - alive)
    assert deadlines.due.tolist() == [ticks, ticks]
    assert deadlines.missed.tolist() == [0, ticks - 1]
    assert deadlines.stopped.tolist() == [0, ticks - alive]
    assert deadlines.late.tolist() == [0, 0]
    assert everybody.silent == []


def test_what_comes_late_is_counted_once_and_followed_from_then_on() -> None:
    said = {
        0: [command(0, 0), command(1, 0)],
        1: [command(0, 1)],
        2: [command(1, 1), command(0, 2), command(0, 2), command(0, 1)],  # late, in time, and again
        3: [command(0, 3), command(1, 3)],
    }
    found, deadlines, _ = spoken(said, 4)
    assert found == [[0, 0], [1, 0], [2, 1], [3, 3]]
    assert deadlines.missed.tolist() == [0, 2]
    assert deadlines.late.tolist() == [0, 1]
    assert deadlines.table()["missed_share"] == 2 / 8


def test_who_says_nothing_for_long_is_left_out() -> None:
    ticks = round(live.HANG_TIMEOUT / TICK) + 1
    _, _, everybody = spoken({tick: [command(0, tick)] for tick in range(ticks)}, ticks)
    assert everybody.silent == [[1]]


def test_a_command_of_a_tick_to_come_is_refused() -> None:
    found, deadlines, _ = spoken({0: [command(0, 1), command(1, 0)]}, 2)
    assert found == [[-1, 0], [-1, 0]]
    assert deadlines.late.tolist() == [0, 0]


def test_an_agent_answers_the_newest_tick_and_counts_those_it_skipped() -> None:
    async def main() -> tuple[list[int], Turns]:
        loop = asyncio.get_running_loop()
        inbox = Inbox(loop)
        turns = Turns((0, 1), inbox, Mouth.__new__(Mouth), Complaints(logging.getLogger("test")))
        world = Presence("the world", inbox)

        def sense(robot: int, tick: int, since: int = 0, over: bool = False) -> None:
            sensed = Observation(tick, robot, (0.0, 0.0, 0.0), NOTHING, NOTHING.astype(np.uint8), over, since)
            inbox.put(keys.observation("test", robot), messages.encode_observation(sensed))

        answered = []
        for tick in (0, 1, 2):
            sense(0, tick)
        sense(1, 0)
        sense(1, 1)  # robot 1's of tick 2 is on its way
        async for observations in turns.live(world):
            assert {one.tick for one in observations} == {turns.tick}
            answered.append(turns.tick)
            if turns.tick == 1:
                for tick in (2, 3, 4, 5):
                    sense(1, tick)
                    sense(0, tick)
            elif turns.tick == 5:
                for robot in (0, 1):
                    sense(robot, 900, since=900)  # it was away: nothing was skipped
            elif turns.tick == 900:
                sense(0, 901, over=True)
        return answered, turns

    answered, turns = asyncio.run(main())
    assert answered == [1, 5, 900]
    assert turns.skipped == 3


class Nobody:
    """A bus on which nobody listens."""

    def publisher(self, key: str, schema: str) -> Any:
        return lambda payload: None

    def serve(self, key: str, handler: Any) -> None: ...


def test_a_mouth_that_skips_ticks_forgets_as_much() -> None:
    mouth = Mouth(Nobody(), "test", (0,), Complaints(logging.getLogger("test")))  # type: ignore[arg-type]
    for tick in range(0, 3000, 3):
        mouth.say(tick, [(0, b"beacon", b"command")])
    assert len(mouth._commands) <= 2
    assert len(mouth._beacons) <= 2


def test_an_agent_that_is_suspended_for_longer_than_its_lease_is_taken_in_again(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    words = [str(CONFIGS / "pair.toml"), "--set", "run.clock=live", "--duration", "14", "--out", "out"]
    world = start(command_line("world.process", *words, "-l", endpoint), tmp_path)
    agents = [start(command_line("agents.process", "--id", str(at), "-e", endpoint), tmp_path) for at in (0, 1)]
    assert world.stderr is not None
    while "starts" not in world.stderr.readline():
        assert world.poll() is None
    time.sleep(1.5)
    agents[1].send_signal(signal.SIGSTOP)
    time.sleep(5.0)
    agents[1].send_signal(signal.SIGCONT)
    _, told = world.communicate(timeout=PATIENCE)
    for agent in agents:
        agent.communicate(timeout=PATIENCE)
        assert agent.returncode == 0
    assert "robot 1 is not there from tick" in told
    assert "robot 1 is back from tick" in told
    kept = json.loads((tmp_path / "out" / "summary.json").read_text())["deadlines"]
    assert kept["due"][0] == 700 > kept["due"][1] > 300


def live_through(scenario: Scenario, path: Path, story: Any) -> dict[str, Any]:
    """A recorded run on the live clock, while `story(server)` happens."""

    async def main() -> dict[str, Any]:
        async with session.router() as (opened, endpoint), asyncio.timeout(60.0):
            with Recorder(path, scenario, "test", "processes") as recorder:
                server = Server(opened, Course(scenario, recorder), "test", session.RUN)
                agents = [
                    asyncio.ensure_future(session.live(endpoint, [robot])) for robot in range(scenario.robots.number)
                ]
                await server.gather()
                running = asyncio.ensure_future(server.run())
                await story(server)
                await running
                server.dismiss()
                await asyncio.gather(*agents)
                summary = server.summarize()
                assert summary is not None
                recorder.conclude(summary)
                return summary

    return asyncio.run(main())


def test_a_run_takes_as_long_as_it_simulates_and_its_world_can_be_executed_again(tmp_path: Path) -> None:
    async def story(server: Server) -> None: ...

    begun = time.monotonic()
    scenario = load("pair.toml", run__duration=3.0, run__clock="live", run__clock_skew=0.05)
    summary = live_through(scenario, tmp_path / "run.mcap", story)
    assert time.monotonic() - begun >= 3.0 - WARM_UP * TICK - 0.05
    kept = summary["deadlines"]
    assert summary["clock"] == "live"
    assert kept["due"] == [150, 150]
    assert sum(kept["missed"]) < 300
    found = log.load(tmp_path / "run.mcap")
    assert replay.again(found) == json.loads(json.dumps(summary))
    with pytest.raises(FesError, match=r"is of the live clock: what came too late for a robot is not in it$"):
        replay.again(found, everybody=True)


def test_nobody_waits_for_a_robot_that_says_nothing_and_it_stops(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("world.live.HANG_TIMEOUT", 1.0)
    mute, say = asyncio.Event(), Mouth.say
    monkeypatch.setattr(
        Mouth, "say", lambda mouth, tick, said: None if mute.is_set() and said[0][0] == 1 else say(mouth, tick, said)
    )
    seen: dict[str, Any] = {}

    async def until(holds: Any) -> None:
        while not holds():
            await asyncio.sleep(0.01)

    async def story(server: Server) -> None:
        course = server.course
        await until(lambda: course.state.tick >= WARM_UP + 15)
        mute.set()
        await until(lambda: not course.state.present[1])
        seen["gone"], pose = course.state.tick, course.state.poses[1].tolist()
        await until(lambda: course.state.tick >= seen["gone"] + 20)
        seen["stood"] = course.state.poses[1].tolist() == pose
        mute.clear()

    scenario = load("pair.toml", run__duration=4.0, run__clock="live")
    summary = live_through(scenario, tmp_path / "run.mcap", story)
    assert seen["stood"]
    assert seen["gone"] >= WARM_UP + 15 + round(1.0 / TICK) - 1
    assert summary["ticks"] == 200
    kept = summary["deadlines"]
    assert kept["missed"][1] >= 45
    assert kept["stopped"][1] >= 30
    assert replay.again(log.load(tmp_path / "run.mcap"))["digest"] == summary["digest"]


def test_a_world_that_is_late_slips_and_gives_every_robot_a_whole_tick(monkeypatch: pytest.MonkeyPatch) -> None:
    _, deadlines, everybody = world_of_two()
    now, slept = [100.0], list[float]()

    async def sleep(seconds: float) -> None:
        slept.append(seconds)
        now[0] += seconds + (0.5 if len(slept) == 2 else 0.001)

    monkeypatch.setattr("world.live.time.monotonic", lambda: now[0])
    monkeypatch.setattr("world.live.asyncio.sleep", sleep)

    async def main() -> None:
        inbox, complaints = Inbox(asyncio.get_running_loop()), Complaints(logging.getLogger("test"))
        held = Held(inbox, everybody, complaints, deadlines, TICK)  # type: ignore[arg-type]
        for _ in range(4):
            await held._end_of_tick()

    asyncio.run(main())
    assert slept == pytest.approx([0.02, 0.019, 0.02, 0.019])
    assert deadlines.slipped == pytest.approx(0.5)


def test_the_dashboard_shows_what_was_missed_and_whose_it_was() -> None:
    report = a_report([(0.0, 0.0), (1.0, 0.0)], missed=np.array([1, 4]), late=np.array([0, 3]))
    shown = "".join(text for text, *_ in header.header(report, 120)[1])
    assert "live, deadlines missed 5, 22.73%, robot 1 4" in shown
    assert "late 3" in shown


def test_ten_processes_keep_the_formation_on_the_live_clock(tmp_path: Path) -> None:
    words = ["run", "configs/neighborhood.toml", "--clock", "live", "--duration", "14", "--json", "--out"]
    ended = subprocess.run(
        fes(*words, str(tmp_path / "out")), capture_output=True, text=True, timeout=PATIENCE + 30, check=False
    )
    assert ended.returncode == 0, ended.stderr
    summary = json.loads(ended.stdout)
    assert summary["deadlines"]["due"] == [700] * 10
    assert summary["wall_s"] >= 14.0 - WARM_UP * TICK - 0.05
    assert summary["estimate_error_max"] < 0.5
    assert summary["separation_error_rms"] < 5.0  # m; it is on its way, as in lockstep


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--backend", "inprocess"], "run.clock: 'live' needs processes"),
        (["--rtf", "2"], "--rtf does not go with the live clock"),
    ],
)
def test_what_does_not_go_with_the_live_clock_is_one_line(words: list[str], complaint: str, tmp_path: Path) -> None:
    ended = subprocess.run(
        fes("run", "configs/pair.toml", "--clock", "live", "--out", str(tmp_path / "out"), *words),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert ended.returncode == 1
    assert complaint in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()
