"""fes replay on the logs of real robots, as a person calls it; a robot that is killed leaves a log that is read."""

import json
import re
import sys
from pathlib import Path

import pytest

from fes.recording.robot_log import reader
from tests.support import recordings, robot_logs
from tests.support.commands import call
from tests.support.processes import alive, start, until

LINE = "robot 1, executed again: 200 ticks, the same to the bit\n"

ROBOT = """
import sys, time
from pathlib import Path
from fes.recording.robot_log.recorder import RobotLog
from tests.support import robot_logs
log = RobotLog(Path("robot-1.mcap"), robot_logs.header(1))
robot_logs.add(log, robot_logs.steps(1))
print(log._log.pid, flush=True)
time.sleep(1000)
"""
"""A robot that makes its steps at once, and is killed while it waits."""


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the logs of two robots."""
    folder = tmp_path_factory.mktemp("robots")
    for robot in (0, 1):
        robot_logs.write(folder / f"robot-{robot}.mcap", robot)
    return folder


@pytest.mark.parametrize("words", [["robot-1.mcap"], ["robot-1.mcap", "--robot=1"], [".", "--robot=1"]], ids=" ".join)
def test_a_robot_is_executed_again_to_the_bit(logs: Path, words: list[str]) -> None:
    done = call(logs, "fes", "replay", *words)
    assert (done.returncode, done.stdout, done.stderr) == (0, LINE, "")
    as_json = call(logs, "fes", "replay", *words, "--json")
    assert (as_json.returncode, json.loads(as_json.stdout), as_json.stderr) == (0, {"robot": 1, "ticks": 200}, "")


def test_all_robots_of_a_folder_are_executed_again_one_line_each(logs: Path) -> None:
    done = call(logs, "fes", "replay", ".", "--all")
    assert (done.returncode, done.stdout, done.stderr) == (0, LINE.replace("1", "0", 1) + LINE, "")
    as_json = call(logs, "fes", "replay", ".", "--all", "--json")
    assert json.loads(as_json.stdout) == [
        {"log": f"robot-{robot}.mcap", "robot": robot, "ticks": 200, "ended": "at its end"} for robot in (0, 1)
    ]


def test_a_change_is_one_line_that_names_it_and_one_with_both_versions(logs: Path, tmp_path: Path) -> None:
    edit = robot_logs.edited(40, lambda step: setattr(step, "command", step.command[:-1]))
    recordings.rewrite(logs / "robot-1.mcap", tmp_path / "robot-1.mcap", edit)
    done = call(tmp_path, "fes", "replay", "robot-1.mcap", "--json")
    assert (done.returncode, done.stdout) == (1, "")
    error, note = done.stderr.splitlines()
    assert error.startswith("fes: error: tick 40, Command of robot 1: payload (")
    assert re.match(r"fes: recorded by fes .* with arithmetic .*; executed by fes .* with arithmetic ", note)


def test_a_log_has_one_robot_and_other_commands_say_that_it_is_not_of_a_run(logs: Path) -> None:
    for words, rule in (
        (["replay", "robot-1.mcap", "--all"], "--all: robot-1.mcap is the log of one robot"),
        (["replay", "robot-1.mcap", "--robot=0"], "--robot 0: robot-1.mcap is the log of robot 1"),
        (["replay", "."], ". holds 2 logs of robots: give --robot I or --all"),
        (
            ["compare", "robot-1.mcap", "robot-1.mcap"],
            "robot-1.mcap is the log of a robot, not of a run: fes replay executes its code again",
        ),
    ):
        done = call(logs, "fes", *words)
        assert (done.returncode, done.stdout, done.stderr) == (1, "", f"fes: error: {rule}\n")


def test_a_killed_robot_leaves_its_steps_and_one_line_about_the_end(tmp_path: Path) -> None:
    running = start([sys.executable, "-c", ROBOT], tmp_path)
    assert running.stdout is not None
    writer = int(running.stdout.readline())
    path = tmp_path / "robot-1.mcap"
    header = path.stat().st_size
    until(lambda: path.stat().st_size > header + 10_000)  # a chunk with the steps is complete
    running.kill()
    running.communicate()
    until(lambda: not alive(writer))
    assert reader.load(path).ended is None
    done = call(tmp_path, "fes", "replay", "robot-1.mcap")
    assert (done.returncode, done.stdout) == (1, LINE)
    assert done.stderr == (
        "fes: error: robot-1.mcap has no end, its robot was killed or the file was cut: 200 steps are there\n"
    )
