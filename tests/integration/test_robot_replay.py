"""A real robot's code executed again from its own log: the same to the bit, and each difference is named."""

from collections.abc import Callable
from pathlib import Path

import pytest

from console.replay import robot_steps
from console.replay.recorded import Mismatch
from fes.errors import FesError
from fes.extension import registry
from fes.protocol import messages
from fes.recording.messages_pb2 import RobotStep
from fes.recording.robot_log import reader
from fes.recording.robot_log.layout import Header
from fes.recording.robot_log.reader import RecordedStep
from fes.recording.robot_log.recorder import RobotLog
from fes.recording.writer.log_file import LogFile
from tests.support import cores, recordings, robot_logs
from world.config.scenario import agent_config

ROBOT, TICK = 1, 40
"""Robot and tick of the changes."""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of a robot that hears two others."""
    return robot_logs.write(tmp_path_factory.mktemp("robot") / "robot-1.mcap", ROBOT)


def rerun(path: Path) -> int:
    return robot_steps.rerun(reader.load(path))


@pytest.mark.parametrize("robot", range(3))
def test_a_robot_executed_again_sends_what_its_log_holds(tmp_path: Path, robot: int) -> None:
    path = robot_logs.write(tmp_path / "robot.mcap", robot)
    assert any(step.beacons for step in robot_logs.steps(robot))  # it has heard others
    assert rerun(path) == len(robot_logs.steps(robot)) == 200
    with cores.only_numpy():
        assert rerun(path) == 200


def of_command(step: RobotStep) -> None:
    step.command = flipped(step.command)


def of_beacon(step: RobotStep) -> None:
    step.beacon = flipped(step.beacon)


def flipped(payload: bytes) -> bytes:
    """A payload with the last bit of its first float64 flipped."""
    place = payload.index(b"\xcb") + 8  # in msgpack, that byte begins a float64
    return payload[:place] + bytes([payload[place] ^ 1]) + payload[place + 1 :]


@pytest.mark.parametrize(
    ("change", "message"), [(of_command, "Command"), (of_beacon, "Beacon")], ids=["command", "beacon"]
)
def test_a_changed_bit_of_an_output_is_named_with_tick_message_and_both_values(
    recorded: Path, tmp_path: Path, change: Callable[[RobotStep], None], message: str
) -> None:
    recordings.rewrite(recorded, tmp_path / "robot.mcap", robot_logs.edited(TICK, change))
    field = {"Command": "twist.linear", "Beacon": "pose.x"}[message]
    with pytest.raises(Mismatch) as caught:
        rerun(tmp_path / "robot.mcap")
    start = f"tick {TICK}, {message} of robot {ROBOT}: {field} is "
    assert str(caught.value).startswith(start)
    assert str(caught.value).endswith(" executed again")
    [note] = caught.value.__notes__
    assert note.startswith("recorded by fes ")


def of_observation(step: RobotStep) -> None:
    step.observation = flipped(step.observation)


def of_heard(step: RobotStep) -> None:
    beacon = messages.decode_beacon(step.beacons[0])
    x, y, heading = beacon.pose
    step.beacons[0] = messages.encode_beacon(beacon._replace(pose=(x + 1e-9, y, heading)))


@pytest.mark.parametrize("change", [of_observation, of_heard], ids=["observation", "heard beacon"])
def test_a_changed_bit_of_an_input_changes_the_outputs_of_its_tick(
    recorded: Path, tmp_path: Path, change: Callable[[RobotStep], None]
) -> None:
    tick = next(step.tick for step in robot_logs.steps(ROBOT) if step.tick > TICK and step.beacons)
    recordings.rewrite(recorded, tmp_path / "robot.mcap", robot_logs.edited(tick, change))
    with pytest.raises(Mismatch, match=rf"^tick {tick}, (Beacon|Command) of robot {ROBOT}: "):
        rerun(tmp_path / "robot.mcap")


def drop_observation(step: RobotStep) -> None:
    step.observation = b""


def of_other_robot(step: RobotStep) -> None:
    sensed = messages.decode_observation(step.observation)
    step.observation = messages.encode_observation(sensed._replace(robot=2))


def of_other_tick(step: RobotStep) -> None:
    sensed = messages.decode_observation(step.observation)
    step.observation = messages.encode_observation(sensed._replace(tick=TICK + 1))


def twice(step: RobotStep) -> None:
    step.beacons.extend(list(step.beacons) or [beacon_of(TICK - 1)] * 2)


def of_another_time(step: RobotStep) -> None:
    del step.beacons[:]
    step.beacons.append(beacon_of(TICK))


def beacon_of(tick: int) -> bytes:
    return robot_logs.steps(0)[tick].beacon


IMPOSSIBLE = {
    "is not msgpack": drop_observation,
    "robot 1 received an Observation of robot 2": of_other_robot,
    "robot 1 received Observation of tick 41, not of 40": of_other_tick,
    "which are not ascending": twice,
    "robot 1 received Beacon of tick 40, not of 39": of_another_time,
}


@pytest.mark.parametrize(("rule", "change"), IMPOSSIBLE.items(), ids=IMPOSSIBLE.keys())
def test_inputs_that_no_robot_received_are_one_line_with_their_tick(
    recorded: Path, tmp_path: Path, rule: str, change: Callable[[RobotStep], None]
) -> None:
    path = tmp_path / "robot.mcap"
    recordings.rewrite(recorded, path, robot_logs.edited(TICK, change))
    with pytest.raises(FesError) as caught:
        rerun(path)
    assert str(caught.value).startswith(f"{path}: tick {TICK}: ")
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)


def since(step: RecordedStep, tick: int) -> RecordedStep:
    """A step of a robot that takes part from `tick` on, if it is not earlier."""
    sensed = messages.decode_observation(step.observation)
    if step.tick < tick:
        return step
    return step._replace(observation=messages.encode_observation(sensed._replace(since=tick)))


def test_a_robot_that_was_absent_starts_without_state(tmp_path: Path) -> None:
    restarted = [since(step, 100) for step in robot_logs.steps(ROBOT)]
    steps = robot_logs.executed(restarted, ROBOT)
    assert steps[99].command == robot_logs.executed(robot_logs.steps(ROBOT), ROBOT)[99].command
    assert steps[150].command != robot_logs.executed(robot_logs.steps(ROBOT), ROBOT)[150].command
    assert rerun(robot_logs.write(tmp_path / "robot.mcap", ROBOT, steps)) == 200


def test_a_robot_that_missed_ticks_is_executed_again_across_them(tmp_path: Path) -> None:
    late = [step for step in robot_logs.steps(ROBOT) if step.tick not in (50, 51, 52, 120)]
    steps = robot_logs.executed(late, ROBOT)
    assert rerun(robot_logs.write(tmp_path / "robot.mcap", ROBOT, steps)) == 196


def test_a_robot_with_an_extension_is_executed_again_only_with_the_same_code(tmp_path: Path) -> None:
    registry.use("tests.support.broken_laws")
    changed = robot_logs.scenario().formation.model_copy(update={"law": "tests.support.broken_laws:Law"})
    config = agent_config(robot_logs.scenario()).model_copy(update={"formation": changed})
    header = Header.now("field", ROBOT, "a1b2", config)
    [entry] = header.extensions
    assert (entry["kind"], entry["name"]) == ("formation law", "tests.support.broken_laws:Law")
    for number, extensions in enumerate([[entry], [], [{**entry, "sha256": "0" * 64}]]):
        with RobotLog(tmp_path / str(number), header._replace(extensions=extensions), writer=LogFile) as log:
            robot_logs.add(log, robot_logs.executed(robot_logs.steps(ROBOT), ROBOT, config))
    assert rerun(tmp_path / "0") == 200
    with pytest.raises(FesError, match=r"1: formation law '.*:Law' was not recorded$"):
        rerun(tmp_path / "1")
    with pytest.raises(FesError, match=r"2: the source of formation law '.*:Law' has changed: SHA-256 000000000000"):
        rerun(tmp_path / "2")
