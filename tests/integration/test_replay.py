"""A recorded run executed again: the same to the bit, and each difference is named."""

import json
import os
import signal
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader

from console.analysis import command as analysis_command
from console.analysis import history
from console.backends import inprocess
from console.replay import command as replay_command
from console.replay import compare, log
from console.replay.recorded import Mismatch
from fes.errors import FesError
from fes.protocol import messages, world_info
from fes.system import fingerprint
from tests.support import recordings
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, alive, children, fes, start, until
from world.execution.recorder import Recorder

SHORT = {"run__duration": 2.0}


def as_json(summary: dict[str, Any]) -> Any:
    return json.loads(json.dumps(summary))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A recorded run of the measured index, and its summary."""
    path = tmp_path_factory.mktemp("replay") / "run.mcap"
    return path, recordings.record(path, load("measured.toml", **SHORT), "measured")


Recorded = tuple[Path, dict[str, Any]]


SHIFT = 1e-6  # rad/s


def shifted(payload: bytes) -> bytes:
    """A command with another angular velocity."""
    command = messages.decode_command(payload)
    return messages.encode_command(command._replace(twist=(command.twist[0], command.twist[1] + SHIFT)))


@pytest.fixture(scope="module")
def tampered(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same log with robot 3's command of tick 40 changed."""
    path = tmp_path_factory.mktemp("tampered") / "run.mcap"
    recordings.rewrite(recorded[0], path, recordings.edited("/commands", 40, 3, shifted))
    return path


def test_summary_digest_and_figures_are_those_of_the_live_run(recorded: Recorded) -> None:
    path, summary = recorded
    loaded = log.load(path)
    assert replay_command.rerun(loaded) == replay_command.rerun(loaded, all_robots=True) == as_json(summary)
    live, drawn = history.follow(loaded.scenario), history.recorded(loaded)
    assert drawn.digest == live.digest == summary["digest"]
    for field in ("time", "poses", "disagreement", "estimate_error", "separation_error"):
        np.testing.assert_array_equal(getattr(drawn, field), getattr(live, field))


def test_a_run_of_ten_processes_can_be_reexecuted_in_one_loop(tmp_path: Path) -> None:
    words = ["run", str(CONFIGS / "measured.toml"), "--duration", "2", "--headless", "--json", "--out", "out"]
    done = subprocess.run(fes(*words), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    loaded = log.load(tmp_path / "out")
    assert loaded.backend == "processes"
    assert replay_command.rerun(loaded, all_robots=True) == summary
    assert replay_command.rerun_robot(loaded, 3) == summary["ticks"] == 100
    recordings.record(tmp_path / "loop.mcap", loaded.scenario)
    assert compare.first_difference(loaded, log.load(tmp_path / "loop.mcap")) is None


@pytest.mark.parametrize("robot", range(10))
def test_a_robot_reexecuted_alone_sends_its_recorded_beacons_and_commands(recorded: Recorded, robot: int) -> None:
    assert replay_command.rerun_robot(log.load(recorded[0]), robot) == recorded[1]["ticks"]


def test_a_change_is_named_with_tick_robot_field_and_both_values(recorded: Recorded, tampered: Path) -> None:
    commands = [tick.payloads.commands for tick in log.load(recorded[0]).ticks()][40]
    true = messages.decode_command(commands[3]).twist[1]
    other = true + SHIFT
    expected = f"tick 40, Command of robot 3: twist.angular is {other!r} in the log and {true!r} executed again"
    for execute in (
        lambda result: replay_command.rerun(result, all_robots=True),
        lambda result: replay_command.rerun_robot(result, 3),
    ):
        with pytest.raises(Mismatch) as caught:
            execute(log.load(tampered))
        assert str(caught.value) == expected
    assert replay_command.rerun_robot(log.load(tampered), 4) == recorded[1]["ticks"]  # robot 4 cannot know
    with pytest.raises(Mismatch, match=r"^tick 41, Observation of robot 3: pose\.x is "):
        replay_command.rerun(log.load(tampered))  # the world does not ask why a robot moves


def test_a_summary_that_the_log_does_not_yield_is_named(recorded: Recorded, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    pair = load("pair.toml", run__duration=0.5)
    with Recorder(path, pair, "test", "inprocess") as recorder:
        recorder.conclude({**inprocess.run(pair, "test", recorder=recorder), "digest": "0" * 64})
    with pytest.raises(FesError, match=r"^summary: digest is '0000"):
        replay_command.rerun(log.load(path))


def test_compare_names_the_first_difference(recorded: Recorded, tampered: Path, tmp_path: Path) -> None:
    first = log.load(recorded[0])
    assert compare.first_difference(first, first) is None
    assert list(compare.of_scenarios(first, first)) == []

    difference = compare.first_difference(first, log.load(tampered))
    assert difference is not None
    assert (difference.tick, difference.message, difference.robot, difference.field) == (
        40,
        "Command",
        3,
        "twist.angular",
    )
    assert difference.second == difference.first + SHIFT

    recordings.record(tmp_path / "seed.mcap", load("measured.toml", **SHORT, run__seed=7))
    second = log.load(tmp_path / "seed.mcap")
    assert list(compare.of_scenarios(first, second)) == [("run.seed", 1, 7)]
    assert compare.first_difference(first, second) is not None

    recordings.record(tmp_path / "shorter.mcap", load("measured.toml", run__duration=1.0))
    shorter = compare.first_difference(first, log.load(tmp_path / "shorter.mcap"))
    assert shorter is not None
    assert shorter.describe("in A", "in B") == "tick 50, run: this tick is 'there' in A and 'nothing' in B"


def test_compare_and_replay_return_1_if_anything_differs(recorded: Recorded, tampered: Path) -> None:
    first, second = str(recorded[0]), str(tampered)
    same = subprocess.run(fes("compare", first, first), capture_output=True, text=True, timeout=PATIENCE)
    assert (same.returncode, same.stdout) == (0, "every message of every tick is the same to the bit\n")
    unlike = subprocess.run(fes("compare", first, second), capture_output=True, text=True, timeout=PATIENCE)
    assert unlike.returncode == 1
    assert unlike.stdout.startswith("tick 40, Command of robot 3: twist.angular is ")
    own = fingerprint.origin(world_info.version())
    assert unlike.stdout.splitlines()[1:] == [f"A was recorded by {own}; B was recorded by {own}"]
    again = subprocess.run(fes("replay", second, "--all", "--json"), capture_output=True, text=True, timeout=PATIENCE)
    assert (again.returncode, again.stdout) == (1, "")
    assert again.stderr.startswith("fes: error: tick 40, Command of robot 3: twist.angular is ")
    assert again.stderr.splitlines()[1:] == [f"fes: recorded by {own}; executed by {own}"]
    complete = subprocess.run(fes("replay", first, "--json"), capture_output=True, text=True, timeout=PATIENCE)
    assert (complete.returncode, json.loads(complete.stdout), complete.stderr) == (0, as_json(recorded[1]), "")


def read_without_an_index(path: Path) -> list[int]:
    """The ticks of the Commands in a log of a killed run, by the recipe of docs/reference/log.md."""
    result = []
    with path.open("rb") as file, suppress(McapError):
        for _, _, message in NonSeekingReader(file).iter_messages(topics="/commands", log_time_order=False):
            result.append(message.sequence)
    return result


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_log_of_a_stopped_world_holds_all_ticks_until_then(tmp_path: Path, how: signal.Signals) -> None:
    words = ["run", str(CONFIGS / "pair.toml"), "--duration", "100000", "--out", "out", "--headless"]
    running = start(fes(*words), tmp_path)
    path = tmp_path / "out" / "run.mcap"
    begun = until(lambda: path.exists() and path.stat().st_size)
    until(lambda: path.stat().st_size > begun + 1000)  # a chunk with ticks is complete
    pids = children(running.pid)
    os.kill(next(pid for pid, line in pids.items() if " -m world " in line), how)
    running.communicate(timeout=PATIENCE)
    assert running.returncode == 1
    assert not any(alive(pid) for pid in pids)
    loaded = log.load(path)
    ticks = sum(1 for _ in loaded.ticks())
    assert ticks > 0
    summary = replay_command.rerun(loaded, all_robots=True)
    assert summary["ticks"] == ticks
    assert summary["digest"] == inprocess.run(load("pair.toml", run__duration=ticks * 0.02), "pair")["digest"]
    if how is signal.SIGKILL:
        assert read_without_an_index(path) == list(range(ticks))
        assert loaded.complaint == (
            f"{path} has no end, its run was killed or the file was cut: {ticks} of 5000000 ticks are there"
        )
    else:
        assert loaded.complaint is None
        assert json.loads((tmp_path / "out/summary.json").read_text()) == loaded.summary == summary


def test_the_flags_robot_and_all_exclude_each_other(recorded: Recorded) -> None:
    with pytest.raises(FesError, match=r"^--all executes every robot again: give either --all or --robot 3$"):
        replay_command.replay(recorded[0], robot=3, all_=True)


def test_a_stopped_run_is_reported_as_stopped(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pair, kept = load("pair.toml", run__duration=1.0), list[dict[str, Any]]()

    def fail(report: object) -> None:
        raise FesError("there was a [fault]")

    def run() -> None:
        with Recorder(tmp_path / "run.mcap", pair, "test", "inprocess") as recorder:
            try:
                inprocess.run(pair, "test", rtf=5.0, watch=fail, keep=kept.append, recorder=recorder)
            finally:
                recorder.conclude(*kept)

    with pytest.raises(FesError, match="fault"):
        run()
    [summary] = kept  # the results are kept however a run ends
    replay_command.replay(tmp_path / "run.mcap", json_=True)
    out, err = capfd.readouterr()
    assert json.loads(out) == as_json(summary)
    assert err == "the run ended early: there was a [fault]\n"


def test_figures_are_drawn_from_a_log(recorded: Recorded, tmp_path: Path) -> None:
    analysis_command.plot(str(recorded[0]), out=tmp_path)
    assert {path.name for path in tmp_path.iterdir()} >= {"formation.png", "convergence.svg"}
