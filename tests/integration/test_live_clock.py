"""The live clock: it waits for no robot, and late commands are counted and held."""

import asyncio
import json
import re
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

from agents.runtime.beacon_subscriptions import BeaconSubscriptions
from agents.runtime.outbox import Outbox
from console.backends.process_group import free_port
from console.replay import command as replay_command
from console.replay import log
from fes.errors import FesError
from fes.protocol import keys
from fes.protocol.report import decode_report
from tests.support import session
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, fes, start
from tests.support.processes import command as command_line
from world.config.scenario import Scenario
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.server.live import WARM_UP
from world.server.server import Server

TICK = 0.02  # s


def test_an_agent_that_is_suspended_past_its_lease_rejoins(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    words = [str(CONFIGS / "pair.toml"), "--set", "run.clock=live", "--duration", "14", "--out", "out"]
    world = start(command_line("world.process", *words, "-l", endpoint), tmp_path)
    agents = [start(command_line("agents.process", "--id", str(robot), "-e", endpoint), tmp_path) for robot in (0, 1)]

    async def suspend() -> None:
        async with session.client(endpoint, PATIENCE) as observer, asyncio.timeout(PATIENCE):
            reports, gone = observer.mailbox(keys.report(keys.DEFAULT_RUN)), asyncio.Event()
            while (report := reports.take()) is None or decode_report(report[1] or b"").tick <= WARM_UP:
                await asyncio.sleep(0.01)
            token = keys.robot_alive(keys.DEFAULT_RUN, 1)
            observer.declare_liveliness_subscriber(token, lambda key, alive: None if alive else gone.set())
            agents[1].send_signal(signal.SIGSTOP)
            await gone.wait()
            agents[1].send_signal(signal.SIGCONT)

    asyncio.run(suspend())
    _, output = world.communicate(timeout=PATIENCE)
    for agent in agents:
        agent.communicate(timeout=PATIENCE)
        assert agent.returncode == 0
    assert "robot 1 is absent from tick" in output
    assert "robot 1 is back from tick" in output
    kept = json.loads((tmp_path / "out" / "summary.json").read_text())["deadlines"]
    assert kept["due"][0] == 700 > kept["due"][1] > 300


def live_through(scenario: Scenario, path: Path, story: Any) -> dict[str, Any]:
    """Record a run on the live clock while `story(server)` happens."""

    async def main() -> dict[str, Any]:
        async with session.router() as (opened, endpoint), asyncio.timeout(PATIENCE):
            with Recorder(path, scenario, "test", "processes") as recorder:
                server = Server(opened, Run(scenario, recorder), "test", session.RUN)
                agents = [
                    asyncio.ensure_future(session.live(endpoint, [robot])) for robot in range(scenario.robots.number)
                ]
                await server.gather()
                running = asyncio.ensure_future(server.main_loop())
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
    loaded = log.load(tmp_path / "run.mcap")
    assert replay_command.rerun(loaded) == json.loads(json.dumps(summary))
    with pytest.raises(
        FesError, match=r"is of the live clock: the log does not show which inputs a robot received in time$"
    ):
        replay_command.rerun(loaded, all_robots=True)


def test_a_silent_robot_stops_and_delays_no_tick(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("world.execution.live_tick.HANG_TIMEOUT", 1.0)
    mute, say = asyncio.Event(), Outbox.publish
    published, unsaid = list[int](), list[tuple[Outbox, int, Any]]()

    def publish(outbox: Outbox, tick: int, answers: Any) -> None:
        if answers[0][0] == 1 and mute.is_set():
            unsaid.append((outbox, tick, answers))
            return
        if answers[0][0] == 1:
            published.append(tick)
        say(outbox, tick, answers)

    monkeypatch.setattr(Outbox, "publish", publish)
    seen: dict[str, Any] = {}

    async def until(holds: Any) -> None:
        while not holds():
            await asyncio.sleep(0.01)

    async def story(server: Server) -> None:
        run = server.run
        await until(lambda: run.state.tick >= WARM_UP + 15)
        mute.set()
        await until(lambda: not run.state.present[1])
        seen["gone"], pose = run.state.tick, run.state.poses[1].tolist()
        seen["heard"] = published[-1]
        await until(lambda: run.state.tick >= seen["gone"] + 20)
        seen["stood"] = run.state.poses[1].tolist() == pose
        mute.clear()
        say(*unsaid[-1])  # as after a hang: the process continues where it stopped
        await until(lambda: run.state.present[1] or run.is_over)
        seen["back"] = run.state.since[1]

    scenario = load("pair.toml", run__duration=4.0, run__clock="live")
    summary = live_through(scenario, tmp_path / "run.mcap", story)
    assert seen["stood"]
    assert seen["gone"] >= seen["heard"] + round(1.0 / TICK)
    assert seen["back"] >= seen["gone"] + 20
    assert summary["ticks"] == 200
    kept = summary["deadlines"]
    assert kept["missed"][1] >= 45
    assert kept["stopped"][1] >= 30
    assert replay_command.rerun(log.load(tmp_path / "run.mcap"))["digest"] == summary["digest"]


def test_a_late_beacon_is_counted_as_lost_and_not_recalled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    heard = BeaconSubscriptions.heard
    monkeypatch.setattr(
        BeaconSubscriptions, "heard", lambda radio, tick: heard(radio, tick) if tick < WARM_UP + 5 else []
    )
    near = load("pair.toml", channel__model="perfect", run__duration=1.0, run__clock="live")

    async def main() -> Any:
        async with asyncio.timeout(PATIENCE):
            return await session.run(near, [[0], [1]])

    summary, _, agents = asyncio.run(main())
    assert summary["ticks"] == 50
    for agent in agents:
        assert re.match(r"[1-9]\d* beacons came too late, \d+ ticks were skipped", agent.lag)
        assert not agent.drops.counts["Beacon: recalled"]


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
    assert summary["separation_error_rms"] < 5.0  # m; it still converges, as in lockstep


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--backend", "inprocess"], "run.clock: 'live' needs processes"),
        (["--rtf", "2"], "--rtf does not go with the live clock"),
    ],
)
def test_a_setting_that_excludes_the_live_clock_is_rejected_in_one_line(
    words: list[str], complaint: str, tmp_path: Path
) -> None:
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
