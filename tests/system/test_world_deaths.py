"""Worlds that die or receive a stop signal, and runs that are resumed by another world process."""

import json
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from console.backends import inprocess
from console.backends.process_group import free_port
from console.replay import command as replay_command
from console.replay import log
from fes.recording.layout import NAME
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, command, fes, start, until
from tests.support.worlds import DURATION, Run, under_way
from world.execution.checkpoint import FOLDER
from world.execution.run import ATTEND, TICK
from world.metrics.summary import write_scenario

MACHINE = ("backend", "wall_s", "ticks_per_s", "real_time_factor", "model_free")
"""Keys of a summary that depend on the machine."""


@pytest.fixture
def run(tmp_path: Path) -> Iterator[Run]:
    with under_way(tmp_path, "neighborhood.toml") as going:
        yield going


def test_a_run_whose_world_is_killed_and_stopped_has_the_same_digest(run: Run) -> None:
    robots = load("neighborhood.toml").robots.number
    for robot in range(robots):
        run.join(robot)
    for how in (signal.SIGKILL, signal.SIGTERM, signal.SIGKILL):
        run.end(how)
        assert run.world.returncode == (0 if how is signal.SIGTERM else -how)
        assert all(agent.poll() is None for agent in run.agents.values())
        run.start("--resume", str(run.out))
    summary = run.finish()
    undisturbed = inprocess.run(load("neighborhood.toml", run__duration=DURATION), "neighborhood")
    assert {**summary, **dict.fromkeys(MACHINE)} == {**undisturbed, **dict.fromkeys(MACHINE)}
    assert replay_command.rerun(log.load(run.out / NAME), all_robots=True)["digest"] == undisturbed["digest"]


def test_fes_run_kills_the_world_as_scheduled_and_the_digest_is_the_same(tmp_path: Path) -> None:
    deaths = [{"at": 2.0, "world_away": 0.5}, {"at": 6.0, "world_away": 0.1}]
    deaths.append({"at": 11.96, "world_away": 0.1})  # perhaps just after its end
    scenario = load("neighborhood.toml", run__duration=12.0, event=deaths)
    write_scenario(tmp_path, scenario)
    words = ["run", "scenario.toml", "--rtf", "4", "--headless", "--json", "--out", "out"]
    words += ["--agents-per-process", "5"]
    ended = subprocess.run(
        fes(*words), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE + 30, check=False
    )
    assert ended.returncode == 0, ended.stderr
    assert json.loads(ended.stdout)["digest"] == inprocess.run(scenario, "scenario")["digest"]
    assert (tmp_path / "out" / "world.log").read_text().count("resumes at tick") >= 2


def test_a_permanently_ended_run_cannot_be_resumed(run: Run) -> None:
    for robot in range(load("neighborhood.toml").robots.number):
        run.join(robot)
    until(lambda: (run.out / NAME).exists() and (run.out / NAME).stat().st_size > 20_000)  # it is running
    run.world.send_signal(signal.SIGINT)
    for process in (run.world, *run.agents.values()):
        process.communicate(timeout=PATIENCE)
        assert process.returncode == 0
    assert not (run.out / FOLDER).exists()


def test_a_resumed_world_remembers_changes_and_deaths_since_the_checkpoint(run: Run) -> None:
    for robot in range(load("neighborhood.toml").robots.number):
        run.join(robot)
    state = run.out / FOLDER / "state"
    until(state.exists)
    done = subprocess.run(
        fes("set", "channel.reference_snr=2e6", "-e", run.endpoint), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    run.come_to_rest(1)  # so that no beacon of robot 1 is in transit, which would be lost with it
    run.world.kill()
    run.world.communicate()
    run.agents[1].kill()
    run.agents[1].communicate()
    run.start("--resume", str(run.out))
    run.join(1)  # a new process without state
    summary = run.finish()
    assert summary["ticks"] == 1000
    assert "2000000.0" in (run.out / "scenario.toml").read_text()
    loaded = log.load(run.out / NAME)
    assert [change for tick in loaded.ticks() for change in tick.changes] == [("channel.reference_snr", 2e6)]
    [gone, back] = [tick for tick in loaded.ticks() if tick.attended]
    assert 1 not in gone.attended[-1]
    assert 1 in back.attended[-1]
    assert replay_command.rerun(loaded, all_robots=True)["digest"] == summary["digest"]


def test_a_resumed_world_repeats_joins_and_leaves_since_the_checkpoint(run: Run) -> None:
    run.world.kill()
    run.world.communicate()
    shutil.rmtree(run.out, ignore_errors=True)
    run.start(str(CONFIGS / run.scenario), "--out", str(run.out), *run.words, every="1000", rtf="1")
    for robot in range(load("neighborhood.toml").robots.number):
        run.join(robot)
    state = run.out / FOLDER / "state"
    until(state.exists)

    def notes() -> list[str]:
        return [kind for kind, *_ in run.notes()]

    until(lambda: notes().count(TICK) > 20)
    run.agents[2].kill()
    run.agents[2].communicate()
    until(lambda: notes().count(ATTEND) == 1)
    run.join(2)
    until(lambda: notes().count(ATTEND) == 2)
    seen = len(notes())
    until(lambda: len(notes()) > seen + 20)
    run.world.kill()
    run.world.communicate()
    run.start("--resume", str(run.out))
    summary = run.finish()
    loaded = log.load(run.out / NAME)
    assert replay_command.rerun(loaded, all_robots=True)["digest"] == summary["digest"]
    assert len([tick for tick in loaded.ticks() if tick.attended]) == 2


def test_a_world_behind_its_robots_reports_it_and_they_end(run: Run, tmp_path: Path) -> None:
    for robot in range(load("neighborhood.toml").robots.number):
        run.join(robot)
    run.next_checkpoint()

    def copied() -> bool:
        with suppress(OSError):  # a journal may be replaced concurrently
            shutil.copytree(run.out / FOLDER, tmp_path / "old", dirs_exist_ok=True)
            return True
        return False

    until(copied)
    seen = until(lambda: max(0, run.reached()))  # a pending checkpoint may come before the next tick
    until(lambda: run.reached() > seen + 3)
    run.world.kill()
    run.world.communicate()
    shutil.rmtree(run.out / FOLDER)
    shutil.copytree(tmp_path / "old", run.out / FOLDER)  # as after a power loss that removed unsynced data
    run.start("--resume", str(run.out))
    for agent in run.agents.values():
        _, err = agent.communicate(timeout=PATIENCE)
        assert agent.returncode == 1
        assert "the world is back at tick" in err.splitlines()[-1]
    run.world.send_signal(signal.SIGINT)
    run.world.communicate(timeout=PATIENCE)


@pytest.mark.parametrize("how", ["--resume", "--out"])
def test_a_second_world_in_a_run_directory_is_rejected_in_one_line(run: Run, how: str) -> None:
    until((run.out / FOLDER / "state").exists)
    before = (run.out / "scenario.toml").read_bytes()
    words = ["--resume", "out"] if how == "--resume" else [str(CONFIGS / "pair.toml"), "--out", "out"]
    second = start(command("world.process", *words, "-l", f"tcp/127.0.0.1:{free_port()}"), run.where)
    try:
        _, err = second.communicate(timeout=PATIENCE)
    finally:
        second.kill()
    assert (second.returncode, err) == (1, "fes-world: error: another world is using out\n")
    assert (run.out / "scenario.toml").read_bytes() == before
