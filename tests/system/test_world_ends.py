"""Ends of a world, and the runs that can be resumed afterwards."""

import resource
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from console.backends import inprocess
from console.backends.process_group import free_port
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, STARTING, alive, children, command, fes, start, until
from tests.support.worlds import DURATION, Run, under_way
from world.execution.checkpoint import FOLDER
from world.metrics.summary import write_scenario


@pytest.fixture
def pair(tmp_path: Path) -> Iterator[Run]:
    """Two robots at twice the pace of the wall clock."""
    with under_way(tmp_path, "pair.toml") as going:
        for robot in (0, 1):
            going.join(robot)
        yield going


def whole() -> str:
    return str(inprocess.run(load("pair.toml", run__duration=DURATION), "pair")["digest"])


def test_a_closed_terminal_does_not_end_a_run_permanently(pair: Run) -> None:
    until(lambda: pair.reached() > 20)
    pair.world.send_signal(signal.SIGHUP)
    _, output = pair.world.communicate(timeout=PATIENCE)
    assert "paused: fes-world --resume " in output
    assert pair.agents[0].poll() is None
    pair.start("--resume", str(pair.out), rtf="max")
    assert pair.finish()["digest"] == whole()


def test_ctrl_c_ends_a_run_permanently_except_while_a_resumed_world_waits_for_its_robots(pair: Run) -> None:
    until(lambda: pair.reached() > 20)
    pair.world.kill()
    pair.world.communicate()
    endpoint, pair.endpoint = pair.endpoint, "tcp/127.0.0.1:0"  # an endpoint that no agent knows
    pair.start("--resume", str(pair.out))
    log: list[str] = []
    assert pair.world.stderr is not None
    while "waiting for the robots that took part" not in (log or [""])[-1]:
        log.append(pair.world.stderr.readline())
        assert log[-1], log
    pair.world.send_signal(signal.SIGINT)
    _, output = pair.world.communicate(timeout=PATIENCE)
    assert "paused: fes-world --resume " in output
    pair.endpoint = endpoint
    pair.start("--resume", str(pair.out))
    before = pair.reached()
    until(lambda: pair.reached() > before + 5)
    pair.world.send_signal(signal.SIGINT)
    _, output = pair.world.communicate(timeout=PATIENCE)
    assert "ended early" in output
    assert not (pair.out / FOLDER).exists()
    assert [agent.wait(PATIENCE) for agent in pair.agents.values()] == [0, 0]


def test_a_world_on_a_full_disk_leaves_its_robots_waiting_for_a_restart(pair: Run) -> None:
    until(lambda: pair.reached() > 20)
    resource.prlimit(pair.world.pid, resource.RLIMIT_FSIZE, (1, resource.RLIM_INFINITY))
    _, output = pair.world.communicate(timeout=PATIENCE)
    assert pair.world.returncode == 1
    assert "paused: fes-world --resume " in output
    assert all(agent.poll() is None for agent in pair.agents.values())
    pair.start("--resume", str(pair.out), rtf="max")
    assert pair.finish()["digest"] == whole()


def test_a_resumed_run_keeps_its_name(pair: Run) -> None:
    until(lambda: pair.reached() > 20)
    pair.world.send_signal(signal.SIGTERM)
    pair.world.communicate(timeout=PATIENCE)
    other = subprocess.run(
        command("world.process", "--resume", str(pair.out), "--run", "other", "-l", pair.endpoint),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    message = "fes-world: error: --resume continues run 'main', not run 'other'\n"
    assert (other.returncode, other.stderr) == (1, message)
    pair.start("--resume", str(pair.out), "--run", "main", rtf="max")
    assert pair.finish()["digest"] == whole()


def test_a_reused_run_directory_keeps_no_file_of_the_previous_run(tmp_path: Path) -> None:
    """This holds even if the new run fails."""
    (tmp_path / "summary.json").write_text("{}")
    (tmp_path / "run.mcap").write_text("a log")
    words = ["--out", str(tmp_path), "--no-record", "-l", f"tcp/127.0.0.1:{free_port()}"]
    world = start(command("world.process", str(CONFIGS / "pair.toml"), *words), tmp_path)
    assert world.stderr is not None
    while "waiting for 2 robots" not in world.stderr.readline():
        assert world.poll() is None
    world.send_signal(signal.SIGINT)
    world.communicate(timeout=PATIENCE)
    assert [path.name for path in tmp_path.iterdir()] == ["scenario.toml"]


def test_a_killed_launcher_leaves_all_files_of_its_run(tmp_path: Path) -> None:
    write_scenario(tmp_path, load("pair.toml", run__duration=1000.0))
    running = start(fes("run", "scenario.toml", "--headless", "--rtf", "4", "--out", "out"), tmp_path)
    try:
        until((tmp_path / "out" / FOLDER / "trail").exists)
        until(lambda: (tmp_path / "out" / FOLDER / "trail").stat().st_size > 0 and len(children(running.pid)) == 3)
        pids = list(children(running.pid))
    finally:
        running.kill()
        running.communicate()
    until(lambda: not any(alive(pid) for pid in pids))
    assert (tmp_path / "out" / FOLDER / "state").exists()
    assert "paused: fes-world --resume " in (tmp_path / "out/world.log").read_text()


@pytest.mark.parametrize("how", ["kill", "hang"])
def test_a_run_whose_schedule_removes_every_robot_continues_to_its_end(tmp_path: Path, how: str) -> None:
    scenario = load("pair.toml", run__duration=16.0, event=[{"at": 1.0, how: [0, 1]}])
    write_scenario(tmp_path, scenario)
    words = ["run", "scenario.toml", "--headless", "--json", "--rtf", "4", "--out", "out"]
    done = subprocess.run(fes(*words), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stderr) == (0, STARTING.format(2))
    assert inprocess.run(scenario, "scenario")["digest"] in done.stdout
