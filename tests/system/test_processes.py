"""Real processes: `fes run`, worlds and agents by hand; no process is left behind, whichever dies."""

import asyncio
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from console.backends import inprocess
from console.backends.process_group import free_port
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import (
    PATIENCE,
    STARTING,
    alive,
    command,
    fes,
    first_report,
    start,
    started,
    until,
)


@pytest.mark.parametrize("per_process", [1, 3, 10])
def test_the_digest_of_ten_processes_is_that_of_one_loop(tmp_path: Path, per_process: int) -> None:
    words = ["run", str(CONFIGS / "paper.toml"), "--duration", "4", "--headless", "--json"]
    done = subprocess.run(
        fes(*words, "--agents-per-process", str(per_process)),
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["backend"] == "processes"
    assert summary["digest"] == inprocess.run(load("paper.toml", run__duration=4.0), "paper")["digest"]
    assert json.loads((tmp_path / "runs/latest/summary.json").read_text()) == summary


def test_the_digest_is_the_same_while_every_core_is_busy(tmp_path: Path) -> None:
    burn = "import threading, sys\nend = []\nwait = lambda: (sys.stdin.read(), end.append(1))\n"
    burn += "threading.Thread(target=wait).start()\nwhile not end: pass"
    spin = [sys.executable, "-c", burn]
    busy = [subprocess.Popen(spin, stdin=subprocess.PIPE) for _ in range(2 * (os.cpu_count() or 1))]
    try:
        words = ["run", str(CONFIGS / "paper.toml"), "--duration", "2", "--headless", "--json"]
        done = subprocess.run(fes(*words), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    finally:
        for process in busy:
            process.communicate()
    assert done.returncode == 0, done.stderr
    expected = inprocess.run(load("paper.toml", run__duration=2.0), "paper")["digest"]
    assert json.loads(done.stdout)["digest"] == expected


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_every_process_and_keeps_the_results(
    tmp_path: Path, endless: "subprocess.Popen[str]", number: signal.Signals
) -> None:
    pids = started(tmp_path, endless, 2)
    asyncio.run(first_report(tmp_path / "out"))
    endless.send_signal(number)
    out, err = endless.communicate(timeout=PATIENCE)
    assert (endless.returncode, out, err) == (
        1,
        "",
        STARTING.format(2) + f"fes: error: stopped by {number.name}; the results so far are in out\n",
    )
    assert not any(alive(pid) for pid in pids)
    assert json.loads((tmp_path / "out/summary.json").read_text())["ticks"] > 0


def test_no_process_outlives_a_killed_launcher(tmp_path: Path, endless: "subprocess.Popen[str]") -> None:
    pids = started(tmp_path, endless, 2)
    endless.kill()
    endless.communicate(timeout=PATIENCE)
    until(lambda: not any(alive(pid) for pid in pids))


def test_a_run_whose_world_was_stopped_is_not_a_success(tmp_path: Path, endless: "subprocess.Popen[str]") -> None:
    pids = started(tmp_path, endless, 2)
    asyncio.run(first_report(tmp_path / "out"))
    os.kill(next(pid for pid, line in pids.items() if " -m world " in line), signal.SIGTERM)
    out, err = endless.communicate(timeout=PATIENCE)
    assert (endless.returncode, out) == (1, "")
    assert "the world was stopped after" in err
    assert not any(alive(pid) for pid in pids)


def test_a_killed_world_is_named_and_ends_the_run(tmp_path: Path, endless: "subprocess.Popen[str]") -> None:
    pids = started(tmp_path, endless, 2)
    os.kill(next(pid for pid, line in pids.items() if " -m world " in line), signal.SIGKILL)
    _, err = endless.communicate(timeout=PATIENCE)
    assert endless.returncode == 1
    assert err.startswith(STARTING.format(2) + "fes: error: fes-world was ended by SIGKILL (its log: ")
    assert err.count("\n") == 2
    assert not any(alive(pid) for pid in pids)


def test_world_and_agents_started_by_hand_in_any_order_find_each_other(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    agents = [start(command("agents.process", "--id", i, "-e", endpoint), tmp_path) for i in "10"]
    world = start(
        command("world.process", str(CONFIGS / "pair.toml"), "-l", endpoint, "--out", ".", "--duration", "3"),
        tmp_path,
    )
    for process in [world, *agents]:
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0, err
    expected = inprocess.run(load("pair.toml", run__duration=3.0), "pair")
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["digest"] == expected["digest"]


def test_a_world_told_to_stop_dismisses_its_agents(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    words = [str(CONFIGS / "pair.toml"), "-l", endpoint, "--duration", "100000", "--out", "."]
    world = start(command("world.process", *words), tmp_path)
    agent = start(command("agents.process", "--id", "0-1", "-e", endpoint), tmp_path)
    assert agent.stderr is not None
    assert world.stderr is not None
    while "starts" not in world.stderr.readline():
        assert world.poll() is None
    world.send_signal(signal.SIGINT)
    for process in (world, agent):
        process.communicate(timeout=PATIENCE)
        assert process.returncode == 0


def test_a_taken_port_is_reported_in_one_line(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    first = start(command("world.process", str(CONFIGS / "pair.toml"), "-l", endpoint), tmp_path)
    assert first.stderr is not None
    assert "waiting for 2 robots" in first.stderr.readline()
    second = start(command("world.process", str(CONFIGS / "pair.toml"), "-l", endpoint), tmp_path)
    _, err = second.communicate(timeout=PATIENCE)
    first.terminate()
    first.communicate(timeout=PATIENCE)
    assert second.returncode == 1
    assert err == f"fes-world: error: cannot listen on {endpoint}: the address is already in use\n"


def test_an_agent_loads_no_more_than_it_needs(tmp_path: Path) -> None:
    """No plotting, command-line framework, terminal library or scenario, and no channel formula."""
    code = "import sys, agents.process, agents.control.crew; print(*sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)
    modules = set(loaded.stdout.split())
    forbidden = {"matplotlib", "typer", "rich", "mcap", "tomllib", "world", "console", "scipy"}
    assert not forbidden & {name.partition(".")[0] for name in modules}
    assert not {"agents.laws.oracle", "fes.model.outage"} & modules
