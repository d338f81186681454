"""Real processes: `fes run`, worlds and agents by hand; nothing is left behind, whoever dies."""

import asyncio
import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from console.backends import inprocess
from console.backends.process_group import free_port
from console.connect import observer
from console.connect.run_directory import Address
from fes.transport import bus
from fes.transport.endpoints import Endpoints
from tests.loop import CONFIGS, load

PATIENCE = 60.0  # s; how long a test waits for what must come, on a machine of any speed

STARTING = "starting a world and {} robots ...\n"
"""The first line of fes run, on standard error."""

LOOP = "running a world and {} robots in one loop ...\n"
"""The same with one loop."""


def command(module: str, *words: str) -> list[str]:
    return [sys.executable, "-c", f"from {module} import main; main()", *words]


def fes(*words: str) -> list[str]:
    return command("console.cli", *words)


def start(words: list[str], where: Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        words, cwd=where, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def children(pid: int) -> dict[int, str]:
    """Pid and command line of every child of a process; one that ends meanwhile may be left out."""
    found = {}
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):  # the thread has ended
            for child in task.read_text().split():
                with contextlib.suppress(OSError):  # its parent has reaped it
                    line = Path(f"/proc/{child}/cmdline").read_bytes().replace(b"\0", b" ").decode()
                    found[int(child)] = line
    return found


def alive(pid: int) -> bool:
    """Whether a process runs (a zombie does not)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


def until(holds: Callable[[], Any]) -> Any:
    """Wait for something that another process brings about."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        value = holds()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError("what was waited for did not come")


def started(where: Path, running: "subprocess.Popen[str]", robots: int) -> dict[int, str]:
    """Wait until all robots are here and the run goes on; returns the children."""
    log = where / "out" / "world.log"
    until(lambda: log.exists() and "all robots are here" in log.read_text())
    found = children(running.pid)
    assert len(found) == robots + 1
    return found


async def first_report(directory: Path) -> None:
    """Wait until a run has run some ticks, as an observer sees it."""
    address = Address(**json.loads((directory / "endpoint.json").read_text()))
    async with bus.opened(Endpoints("client", (address.endpoint,), timeout=PATIENCE)) as opened:
        async for report in observer.reports(opened, address.run, PATIENCE, PATIENCE):
            if report is not None and report.tick > 0:
                return


@pytest.fixture
def endless(tmp_path: Path) -> Iterator["subprocess.Popen[str]"]:
    """A run of two robots that goes on for a very long time."""
    running = start(
        fes("run", str(CONFIGS / "pair.toml"), "--duration", "100000", "--out", "out", "--json"), tmp_path
    )
    yield running
    if running.poll() is None:
        running.kill()
    running.communicate()


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


def test_the_digest_is_the_same_while_every_core_is_busy_with_something_else(tmp_path: Path) -> None:
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
def test_a_signal_ends_everybody_and_keeps_what_was_reached(
    tmp_path: Path, endless: "subprocess.Popen[str]", number: signal.Signals
) -> None:
    pids = started(tmp_path, endless, 2)
    asyncio.run(first_report(tmp_path / "out"))
    endless.send_signal(number)
    out, err = endless.communicate(timeout=PATIENCE)
    assert (endless.returncode, out, err) == (
        1,
        "",
        STARTING.format(2) + f"fes: error: stopped by {number.name}; what was reached is in out\n",
    )
    assert not any(alive(pid) for pid in pids)
    assert json.loads((tmp_path / "out/summary.json").read_text())["ticks"] > 0


def test_nobody_outlives_a_launcher_that_is_killed(tmp_path: Path, endless: "subprocess.Popen[str]") -> None:
    pids = started(tmp_path, endless, 2)
    endless.kill()
    endless.communicate(timeout=PATIENCE)
    until(lambda: not any(alive(pid) for pid in pids))


def test_a_run_whose_world_was_told_to_stop_is_no_success(tmp_path: Path, endless: "subprocess.Popen[str]") -> None:
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
    found = json.loads((tmp_path / "summary.json").read_text())
    assert found["digest"] == expected["digest"]


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


def test_a_taken_port_is_one_line(tmp_path: Path) -> None:
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
    """No plotting, no command-line framework, no terminal library, no scenario; and not the channel's formula."""
    code = "import sys, agents.process, agents.control.crew; print(*sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)
    modules = set(loaded.stdout.split())
    forbidden = {"matplotlib", "typer", "rich", "mcap", "tomllib", "world", "console", "scipy"}
    assert not forbidden & {name.partition(".")[0] for name in modules}
    assert not {"agents.laws.oracle", "fes.model.outage"} & modules
