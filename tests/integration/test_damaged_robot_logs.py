"""Robots' logs from strangers: any damage, and any bytes as inputs, end in one line."""

from pathlib import Path
from random import Random

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from console.replay import command as replay_command
from console.replay.robot_steps import ReplayedRobot
from fes.errors import FesError
from fes.protocol import messages
from fes.recording.robot_log import reader
from tests.support import damage, robot_logs

ROBOT, CHANGES = 1, 150


def one_line(error: FesError) -> bool:
    return bool(str(error)) and "\n" not in str(error) and len(str(error)) < 1000


def test_any_changed_byte_of_a_robots_log_is_reported_in_one_line(tmp_path: Path) -> None:
    whole = robot_logs.write(tmp_path / "whole", ROBOT, robot_logs.steps(ROBOT)[:50]).read_bytes()
    path, random = tmp_path / "log", Random(18)
    for number in range(CHANGES):
        changed = damage.flip(random, whole) if number % 2 else whole[: random.randrange(len(whole))]
        path.write_bytes(changed)
        with pytest.raises(FesError) as caught:
            replay_command.replay(path, json_=True)
        assert str(caught.value).startswith(str(path))
        assert one_line(caught.value)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> reader.RobotRecording:
    path = tmp_path_factory.mktemp("robot") / "robot-1.mcap"
    return reader.load(robot_logs.write(path, ROBOT, robot_logs.steps(ROBOT)[:50]))


@given(st.randoms(use_true_random=False), st.integers(0, 3))
@settings(max_examples=60)
def test_any_bytes_as_the_payloads_of_a_step_are_executed_or_one_line(
    recording: reader.RobotRecording, random: Random, place: int
) -> None:
    robot, steps = ReplayedRobot(recording), robot_logs.steps(ROBOT)
    last = next(step for step in steps if step.tick > 5 and step.beacons)
    for step in steps[: last.number]:
        robot.step(step)
    fields = [last.observation, last.beacons[0], last.beacon, last.command]
    fields[place] = damage.flip(random, fields[place])
    changed = last._replace(
        observation=fields[0], beacons=[fields[1], *last.beacons[1:]], beacon=fields[2], command=fields[3]
    )
    assume(changed != last)  # two flips of one bit
    error = None
    try:
        robot.step(changed)
    except FesError as caught:
        error = caught
    assert error is None or one_line(error)
    if place == 2:
        assert error is not None
    elif place == 3 and error is None:  # only this field is a statement about the process
        first, second = messages.decode_command(last.command), messages.decode_command(changed.command)
        assert first.is_model_free != second.is_model_free
