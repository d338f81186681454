"""The files of robots' logs under fes replay: with gaps, cut, damaged, of another kind, and several in a folder."""

import json
from pathlib import Path

import pytest

from console.replay import command as replay_command
from console.replay import log as run_logs
from console.replay import robot_steps
from fes.errors import FesError
from fes.recording.robot_log import reader
from tests.support import recordings, robot_logs

ROBOT = 1


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of a robot that hears two others."""
    return robot_logs.write(tmp_path_factory.mktemp("robot") / "robot-1.mcap", ROBOT)


def test_a_gap_in_the_log_ends_the_second_execution_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "robot.mcap"
    robot_logs.write(path, ROBOT, writer=lambda path: robot_logs.Busy(path, [70, 71, 72, 90]))
    with pytest.raises(FesError) as caught:
        robot_steps.rerun(reader.load(path))
    assert str(caught.value) == (
        f"{path} lacks 3 steps before tick 73: robot 1 is the same to the bit up to tick 69, "
        "then its state is unknown"
    )
    robot_logs.write(path, ROBOT, writer=lambda path: robot_logs.Busy(path, [0]))
    with pytest.raises(FesError) as caught:
        robot_steps.rerun(reader.load(path))
    assert str(caught.value) == f"{path} lacks 1 step before tick 1: its state is unknown from its start on"


def test_a_cut_log_is_executed_again_and_then_reported(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = robot_logs.cut(recorded, tmp_path / "robot.mcap")
    with pytest.raises(FesError) as caught:
        replay_command.replay(path)
    assert str(caught.value) == f"{path} has no end, its robot was killed or the file was cut: 200 steps are there"
    assert capsys.readouterr().out == "robot 1, executed again: 200 ticks, the same to the bit\n"


def test_steps_that_are_missing_at_the_end_are_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = robot_logs.write(
        tmp_path / "robot.mcap", ROBOT, writer=lambda path: robot_logs.Busy(path, range(195, 200))
    )
    with pytest.raises(FesError) as caught:
        replay_command.replay(path)
    assert str(caught.value) == f"{path} lacks the last 5 steps: its writer was behind"
    assert capsys.readouterr().out == "robot 1, executed again: 195 ticks, the same to the bit\n"


def test_a_damaged_log_is_one_line(recorded: Path, tmp_path: Path) -> None:
    path, content = tmp_path / "robot.mcap", bytearray(recorded.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(FesError, match=rf"^{path} is damaged at byte [\d,]+: the checksum of a chunk differs$"):
        replay_command.replay(path)


def test_the_log_of_a_robot_is_not_that_of_a_run_and_has_one_robot(recorded: Path) -> None:
    with pytest.raises(FesError) as caught:
        run_logs.load(recorded)
    rule = "is the log of a robot, not of a run: fes replay executes its code again"
    assert str(caught.value) == f"{recorded} {rule}"
    with pytest.raises(FesError, match=rf"^--all: {recorded} is the log of one robot$"):
        replay_command.replay(recorded, all_=True)
    with pytest.raises(FesError, match=rf"^--robot 2: {recorded} is the log of robot 1$"):
        replay_command.replay(recorded, robot=2)


def test_a_folder_of_logs_is_executed_again_robot_by_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for robot in range(3):
        robot_logs.write(tmp_path / f"robot-{robot}.mcap", robot)
    robot_logs.write(tmp_path / "robot-2-2.mcap", 2, reason="it was stopped")  # its second start
    assert replay_command.replay(tmp_path, robot=1, json_=True) == 0
    assert json.loads(capsys.readouterr().out) == {"robot": 1, "ticks": 200}
    line = "robot {}, executed again: 200 ticks, the same to the bit"
    assert replay_command.replay(tmp_path, all_=True) == 0
    lines = [line.format(robot) for robot in (0, 1, 2)]
    assert capsys.readouterr().out.splitlines() == [*lines, f"{line.format(2)}; it ended early: it was stopped"]
    recordings.rewrite(
        tmp_path / "robot-0.mcap",
        tmp_path / "robot-1.mcap",
        robot_logs.edited(40, lambda step: step.ClearField("command")),
    )
    (tmp_path / "robot-0.mcap").write_bytes(b"x")
    assert replay_command.replay(tmp_path, all_=True) == 1
    first, second, *rest = capsys.readouterr().out.splitlines()
    assert first == f"{tmp_path / 'robot-0.mcap'} is not a log: it is not an MCAP file"
    assert second.startswith(f"{tmp_path / 'robot-1.mcap'}: tick 40, Command of robot 0: payload is 'missing' ")
    assert len(rest) == 2
    with pytest.raises(FesError, match=rf"^--robot 3: {tmp_path} has no robot-3\.mcap$"):
        replay_command.replay(tmp_path, robot=3)
    with pytest.raises(FesError, match=rf"^{tmp_path} holds 4 logs of robots: give --robot I or --all$"):
        replay_command.replay(tmp_path)


def test_beside_the_log_of_a_run_robots_are_executed_from_their_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recordings.record(tmp_path / "run.mcap", robot_logs.scenario(run__duration=1.0))
    robot_logs.write(tmp_path / "robot-1.mcap", ROBOT)
    line = "robot {}, executed again: {} ticks, the same to the bit\n"
    for robot, ticks in ((1, 200), (2, 50)):  # robot 2 has no log of its own
        assert replay_command.replay(tmp_path, robot=robot) == 0
        assert capsys.readouterr().out == line.format(robot, ticks)
    assert replay_command.replay(tmp_path, all_=True) == 0
    assert capsys.readouterr().out == line.format(1, 200)
    assert replay_command.replay(tmp_path, json_=True) == 0
    assert json.loads(capsys.readouterr().out)["ticks"] == 50
