"""The process that writes a log, under kills, signals and a full disk: one line ends the run, or the log is whole."""

import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from console.replay import command as replay_command
from console.replay import log
from fes.recording.layout import NAME
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.processes import LOOP, PATIENCE, alive, children, fes, start, until
from world.metrics.summary import write_scenario

RECORD = """
import sys
from pathlib import Path
from console.backends import inprocess
from world.config.scenario import load
from world.execution.recorder import Recorder
with Recorder(Path("run.mcap"), load(Path(sys.argv[1])), "pair", "inprocess") as recorder:
    print(recorder._log.pid, flush=True)
    collect = lambda tick: print(tick.state.tick, flush=True)
    inprocess.run(load(Path(sys.argv[1])), "pair", 1.0, recorder=recorder, collect=collect)
"""
"""A run at the pace of the wall clock, which prints the number of each tick after it was recorded."""

TICKS = 100
"""Ticks of two seconds at this pace."""


@pytest.mark.parametrize(("who", "most"), [("the run", TICKS), ("the run and its writer", 2 * TICKS)])
def test_a_killed_run_loses_at_most_its_last_seconds(tmp_path: Path, who: str, most: int) -> None:
    running = start([sys.executable, "-c", RECORD, str(PAIR)], tmp_path)
    assert running.stdout is not None
    writer = int(running.stdout.readline())
    last = -1
    while last < 3 * TICKS:
        last = int(running.stdout.readline())
    running.kill()
    if who != "the run":
        os.kill(writer, signal.SIGKILL)
    last = max([last, *map(int, running.communicate()[0].split())])
    until(lambda: not alive(writer))
    loaded = log.load(tmp_path / NAME)
    ticks = sum(1 for _ in loaded.ticks())
    assert last - most <= ticks <= last + 2  # a tick may be recorded, and not printed yet
    assert loaded.ended is None
    assert replay_command.rerun(loaded)["ticks"] == ticks


def writer_of(pid: int) -> int:
    """The process that writes the log of a run, below the process `pid`."""

    def found() -> int:
        for child, line in children(pid).items():
            if "fes.recording.writer" in line:
                return child
            if below := next((pid for pid, line in children(child).items() if "fes.recording.writer" in line), 0):
                return below
        return 0

    return int(until(found))


@pytest.fixture(params=["inprocess", "processes"])
def running(request: pytest.FixtureRequest, tmp_path: Path) -> "subprocess.Popen[str]":
    """A run of 1,000 s at the pace of the wall clock, some ticks after its start, as the leader of its session."""
    write_scenario(tmp_path, load("pair.toml", run__duration=1000.0))
    words = ["run", "scenario.toml", "--headless", "--rtf", "1", "--out", "out", "--backend", request.param]
    run = subprocess.Popen(
        fes(*words),
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    path = tmp_path / "out" / NAME
    until(lambda: path.exists() and path.stat().st_size > 5000)
    return run


def test_a_run_whose_writer_is_killed_ends_with_one_line(running: "subprocess.Popen[str]", tmp_path: Path) -> None:
    os.kill(writer_of(running.pid), signal.SIGKILL)
    _, err = running.communicate(timeout=PATIENCE)
    assert running.returncode == 1
    assert err.endswith("cannot write out/run.mcap: the process that writes it was ended by SIGKILL\n")
    assert len(err.splitlines()) == 2
    assert (tmp_path / "out" / "summary.json").exists()


def test_a_run_on_a_full_disk_ends_with_one_line(running: "subprocess.Popen[str]", tmp_path: Path) -> None:
    resource.prlimit(writer_of(running.pid), resource.RLIMIT_FSIZE, (1, resource.RLIM_INFINITY))
    _, err = running.communicate(timeout=PATIENCE)
    assert running.returncode == 1
    assert err.endswith("cannot write out/run.mcap: File too large\n")
    assert len(err.splitlines()) == 2
    assert (tmp_path / "out" / "summary.json").exists()


def test_an_interrupted_terminal_leaves_a_whole_log(running: "subprocess.Popen[str]", tmp_path: Path) -> None:
    writer = writer_of(running.pid)
    os.killpg(running.pid, signal.SIGINT)
    _, err = running.communicate(timeout=PATIENCE)
    assert running.returncode == 1, err
    until(lambda: not alive(writer))
    loaded = log.load(tmp_path / "out")
    assert loaded.summary is not None
    assert loaded.summary["ticks"] == sum(1 for _ in loaded.ticks())
    assert loaded.complaint is None
    assert replay_command.rerun(loaded)["digest"] == loaded.summary["digest"]


def test_signals_to_the_writer_itself_are_ignored(tmp_path: Path) -> None:
    words = [
        "run",
        str(PAIR),
        "--backend",
        "inprocess",
        "--headless",
        "--duration",
        "3",
        "--rtf",
        "1",
        "--out",
        "out",
    ]
    run = start(fes(*words), tmp_path)
    writer = writer_of(run.pid)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        os.kill(writer, number)
    _, err = run.communicate(timeout=PATIENCE)
    assert (run.returncode, err) == (0, LOOP.format(2))
    assert log.load(tmp_path / "out").complaint is None
