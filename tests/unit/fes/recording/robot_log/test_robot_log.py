"""The log of a robot: steps, events and header are read back as they were written, and what is lost is counted."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from fes.errors import FesError
from fes.protocol import messages
from fes.recording.messages_pb2 import RobotState
from fes.recording.robot_log import layout, reader
from fes.recording.robot_log.layout import LOST, MAX_EVENTS, Fix
from fes.recording.robot_log.reader import RecordedEvent, RecordedStep
from fes.recording.robot_log.recorder import RobotLog
from fes.recording.writer.log_file import LogFile
from tests.support import recordings, robot_logs

ROBOT = 2
PAYLOADS = st.binary(max_size=60)
NUMBERS = st.floats(allow_nan=False)


@st.composite
def any_steps(draw: st.DrawFn) -> list[RecordedStep]:
    """Steps of any payloads, some ticks apart."""
    ticks = sorted(draw(st.sets(st.integers(0, 2**53 - 1), min_size=1, max_size=5)))
    fixes = st.none() | st.builds(Fix, st.integers(-(2**63), 2**63 - 1), st.tuples(NUMBERS, NUMBERS, NUMBERS))
    return [
        RecordedStep(
            number, 0, tick, draw(st.integers(0, 2**63)), draw(PAYLOADS), draw(st.lists(PAYLOADS, max_size=3)),
            draw(PAYLOADS), draw(PAYLOADS), draw(fixes),
        )
        for number, tick in enumerate(ticks)
    ]  # fmt: skip


@given(any_steps())
@settings(max_examples=25)
def test_every_step_is_read_back_as_it_was_written(steps: list[RecordedStep]) -> None:
    with TemporaryDirectory() as folder:
        log = reader.load(robot_logs.write(Path(folder) / "robot.mcap", ROBOT, steps))
        assert list(log.steps()) == steps
        assert (log.count, log.complaint) == (len(steps), None)


def test_the_header_is_read_back_with_its_settings_and_arithmetic(tmp_path: Path) -> None:
    log = reader.load(robot_logs.write(tmp_path / "robot.mcap", ROBOT, reason="the permit was withdrawn"))
    assert log.header == robot_logs.header(ROBOT, scale=0.01)
    assert log.ended == log.end == "the permit was withdrawn"
    assert log.origin.startswith("fes ")
    assert reader.load(robot_logs.write(tmp_path / "whole.mcap", ROBOT)).end is None


def test_events_are_read_back_between_the_steps_in_any_values(tmp_path: Path) -> None:
    steps = robot_logs.steps(ROBOT)[:3]
    with RobotLog(tmp_path / "log", robot_logs.header(ROBOT), writer=LogFile, clock=lambda: 7) as log:
        log.event("permit", "permit 4 is valid", permit=4, until=1.5)
        robot_logs.add(log, steps[:2])
        log.event("refusal", "no fix", age=math.inf, why={1, 2})
        log.event("gate", "x" * 10_000, long="y" * 100_000)
        robot_logs.add(log, steps[2:])
    first, *two, second, third, last = reader.load(tmp_path / "log").contents()
    assert first == RecordedEvent("permit", "permit 4 is valid", 7, None, {"permit": 4, "until": 1.5})
    assert [*two, last] == steps
    assert second == RecordedEvent("refusal", "no fix", 7, 1, {"text": "{'age': inf, 'why': {1, 2}}"})
    assert isinstance(third, RecordedEvent)
    assert len(third.text) + len(third.values["text"]) == 2 * layout.MAX_EVENT


def test_steps_that_the_writer_did_not_take_are_counted_in_the_log(tmp_path: Path) -> None:
    warnings = list[str]()
    path, steps = tmp_path / "log", robot_logs.steps(ROBOT)[:10]
    busy = robot_logs.Busy(path, [3, 4, 8, 9])
    with RobotLog(path, robot_logs.header(ROBOT), warnings.append, writer=lambda path: busy) as log:
        robot_logs.add(log, steps)
        assert log.lost == 4
    assert warnings == [f"the process that writes {path} is behind: its log lacks steps"]
    recording = reader.load(path)
    contents = list(recording.contents())
    assert [(step.number, step.lost) for step in recording.steps()] == [
        (0, 0), (1, 0), (2, 0), (5, 2), (6, 0), (7, 0),
    ]  # fmt: skip
    event = contents[3]
    assert isinstance(event, RecordedEvent)
    assert (event.kind, event.values) == (LOST, {"steps": 2, "events": 0})
    assert recording.complaint == f"{path} lacks the last 2 steps: its writer was behind"


def test_more_events_than_a_reader_accepts_are_counted_not_written(tmp_path: Path) -> None:
    with RobotLog(tmp_path / "log", robot_logs.header(ROBOT), writer=LogFile) as log:
        for _ in range(MAX_EVENTS + 10):
            log.event("gate", "held")
        robot_logs.add(log, robot_logs.steps(ROBOT)[:1])
    *events, lost, step = reader.load(tmp_path / "log").contents()
    assert isinstance(lost, RecordedEvent)
    assert isinstance(step, RecordedStep)
    assert len(events) == MAX_EVENTS - 1
    assert lost.values == {"steps": 0, "events": 11}


def test_a_full_disk_costs_one_warning_and_no_error(tmp_path: Path) -> None:
    warnings = list[str]()
    log = RobotLog(
        tmp_path / "log", robot_logs.header(ROBOT), warnings.append, writer=lambda path: LogFile(Path("/dev/full"))
    )
    robot_logs.add(log, robot_logs.steps(ROBOT))
    log.event("gate", "held")
    log.finish()
    robot_logs.add(log, robot_logs.steps(ROBOT))
    assert log.lost == 2 * len(robot_logs.steps(ROBOT))
    assert warnings == ["cannot write /dev/full: No space left on device: the robot continues without a log"]


def test_the_end_names_the_error_that_ended_the_robot(tmp_path: Path) -> None:
    def fail() -> None:
        with RobotLog(tmp_path / "log", robot_logs.header(ROBOT), writer=LogFile) as log:
            robot_logs.add(log, robot_logs.steps(ROBOT)[:1])
            raise FesError("the gate has ended")

    with pytest.raises(FesError, match="the gate has ended"):
        fail()
    assert reader.load(tmp_path / "log").ended == "the gate has ended"


def test_viewers_see_the_robot_ten_times_per_second_on_the_wall_clock(tmp_path: Path) -> None:
    path = robot_logs.write(tmp_path / "log", ROBOT)
    with path.open("rb") as file:
        result = [(channel.topic, message) for _, channel, message in make_reader(file).iter_messages()]
    shown = [message for topic, message in result if topic == "/tf"]
    assert len(shown) == 40  # of 4 s
    times = [message.log_time - robot_logs.START for message in shown]
    assert times == list(range(0, 4_000_000_000, 100_000_000))
    [transform] = FrameTransforms.FromString(shown[-1].data).transforms
    sensed = messages.decode_observation(robot_logs.steps(ROBOT)[195].observation)
    assert (transform.parent_frame_id, transform.child_frame_id) == ("map", "robot_2/base_link")
    x, y, heading = sensed.pose
    assert (transform.translation.x, transform.translation.y) == (x, y)
    z, w = transform.rotation.z, transform.rotation.w
    assert (w * w - z * z, 2.0 * w * z) == pytest.approx((math.cos(heading), math.sin(heading)), abs=1e-12)
    state = RobotState.FromString([message.data for topic, message in result if topic == "/robot/2/state"][-1])
    command = messages.decode_command(robot_logs.steps(ROBOT)[195].command)
    assert (state.linear, state.angular, state.links) == (*command.twist, len(command.links))
    assert state.estimate_mean == pytest.approx(command.estimates.mean())
    remarks = [Log.FromString(message.data).message for topic, message in result if topic == "/log"]
    assert remarks == ["robot 2 of run field", "the gate is open"]


def test_json_in_a_log_has_all_required_fields_and_no_other(tmp_path: Path) -> None:
    with robot_logs.write(tmp_path / "log", ROBOT).open("rb") as file:
        texts = [
            (json.loads(schema.data), json.loads(message.data))
            for schema, channel, message in make_reader(file).iter_messages()
            if schema is not None and channel.message_encoding == "json"
        ]
    assert [rules["title"] for rules, _ in texts] == ["fes.Robot", "fes.RobotEvent"]
    for rules, content in texts:
        assert set(rules["required"]) <= content.keys() <= rules["properties"].keys()


def header_with(**fields: Any) -> recordings.Edit:
    """An edit of the header."""

    def edit(topic: str, tick: int, payload: bytes) -> bytes:
        return json.dumps({**json.loads(payload), **fields}).encode() if topic == "/robot" else payload

    return edit


def without_header(topic: str, tick: int, payload: bytes) -> bytes | None:
    return None if topic == "/robot" else payload


def with_step(change: Callable[[Any], None]) -> recordings.Edit:
    return robot_logs.edited(4, change)


BAD: dict[str, recordings.Edit] = {
    " is a robot's log of format 9; this fes reads format 1": header_with(format=9),
    " is a robot's log of format None; this fes reads format 1": header_with(format=None),
    " is not a log of a robot: it does not begin with its robot": header_with(kind="run"),
    " is not a log of a robot: it does not begin": without_header,
    ": the settings of its robot: dt: ": header_with(config={}),
    ": the settings of its robot: ": header_with(config=[1]),
    "its run and boot are texts": header_with(boot=1),
    "its run and boot are texts, its robot and clocks are integers": header_with(robot=True),
    "its robot is from 0 to 2147483647, got -1": header_with(robot=-1),
    "its notes are a table": header_with(notes=[]),
    "its extensions are tables": header_with(extensions=["x"]),
    ": its header or its end cannot be read: KeyError: 'fingerprint'": header_with(arithmetic={}),
    "its header or its end cannot be read": header_with(versions=1),
    ": a message on /steps has no tick": with_step(lambda step: step.ClearField("tick")),
    ": after step 3 of tick 3 comes step 2 of tick 4": with_step(lambda step: setattr(step, "number", 2)),
    ": after step 3 of tick 3 comes step 4 of tick 3": with_step(lambda step: setattr(step, "tick", 3)),
    ": step 100 is there, and its end is of 10 steps": with_step(lambda step: setattr(step, "number", 100)),
    "a message is not what its topic promises: ": (
        lambda topic, tick, payload: b"\x2a\xff" if topic == "/steps" and tick == 4 else payload
    ),
    "promises: KeyError: 'kind'": lambda topic, tick, payload: b"{}" if topic == "/events" else payload,
    "kind and text of an event are texts": (
        lambda topic, tick, payload: b'{"kind": 1, "text": "", "monotonic_ns": 1}' if topic == "/events" else payload
    ),
}


@pytest.mark.parametrize(("rule", "edit"), BAD.items(), ids=BAD.keys())
def test_a_file_that_is_not_a_robots_log_is_one_line(tmp_path: Path, rule: str, edit: recordings.Edit) -> None:
    good = robot_logs.write(tmp_path / "good", ROBOT, robot_logs.steps(ROBOT)[:10])
    bad = tmp_path / "bad"
    recordings.rewrite(good, bad, edit)
    with pytest.raises(FesError) as caught:
        list(reader.load(bad).contents())
    assert str(caught.value).startswith(str(bad))
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_log_without_a_step_is_one_line(tmp_path: Path) -> None:
    path = robot_logs.write(tmp_path / "log", ROBOT, [])
    with pytest.raises(FesError, match=rf"^{path}: the robot ended before its first step$"):
        reader.load(path)


def test_too_many_events_are_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with RobotLog(tmp_path / "log", robot_logs.header(ROBOT), writer=LogFile) as log:
        robot_logs.add(log, robot_logs.steps(ROBOT)[:1])
        for _ in range(9):
            log.event("gate", "held")
    monkeypatch.setattr(reader, "MAX_EVENTS", 7)
    with pytest.raises(FesError, match=r"after step 0 come more than 7 events$"):
        list(reader.load(tmp_path / "log").contents())


def test_each_start_of_a_robot_has_a_file_of_its_own(tmp_path: Path) -> None:
    created = []
    for robot in (10, 2, 2, 10, 2):
        path = layout.new_path(tmp_path, robot)
        path.touch(exist_ok=False)
        created.append(path.name)
    assert created == ["robot-10.mcap", "robot-2.mcap", "robot-2-2.mcap", "robot-10-2.mcap", "robot-2-3.mcap"]
    for other in ("robot-2-.mcap", "robot-02.mcap", "robot-2.mcap.old", "run.mcap"):
        (tmp_path / other).touch()
    second = ["robot-2.mcap", "robot-2-2.mcap", "robot-2-3.mcap"]
    assert [path.name for path in layout.paths(tmp_path, 2)] == second
    assert [path.name for path in layout.paths(tmp_path)] == [*second, "robot-10.mcap", "robot-10-2.mcap"]
