"""The log of a run: what is in it, in which order, how large it is, and that any reader of MCAP understands it."""

import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader

from console.backends import inprocess
from console.replay import log
from fes.errors import FesError
from fes.protocol import messages
from fes.recording import messages_pb2
from fes.recording.mcap_file import McapFile
from tests.support import recordings
from tests.support.loop import load
from world.config.scenario import Scenario

DURATION = 20.0  # s
MAX_BYTES = 200.0  # a robot-tick


def scenario(name: str) -> Scenario:
    return load(f"{name}.toml", run__duration=DURATION)


@pytest.fixture(scope="module", params=["paper", "measured"])
def recorded(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    return path, recordings.record(path, scenario(request.param), request.param)


Recorded = tuple[Path, dict[str, Any]]


@pytest.mark.slow
def test_the_digest_is_the_same_whether_a_run_is_recorded_or_not(recorded: Recorded) -> None:
    _, summary = recorded
    assert summary["digest"] == inprocess.run(scenario(summary["scenario"]), "test")["digest"]


def test_a_robot_tick_takes_at_most_200_bytes(recorded: Recorded) -> None:
    path, summary = recorded
    assert path.stat().st_size / (summary["ticks"] * summary["robots"]) <= MAX_BYTES


def test_the_readers_of_the_mcap_library_accept_a_log_and_its_checksums(recorded: Recorded) -> None:
    path, summary = recorded
    with path.open("rb") as file:
        linear = [record for record in StreamReader(file, validate_crcs=True).records if isinstance(record, Message)]
        file.seek(0)
        reader = make_reader(file, validate_crcs=True)
        indexed = list(reader.iter_messages())
        contents = reader.get_summary()
        [metadata] = reader.iter_metadata()
    assert contents is not None
    assert contents.statistics is not None
    assert contents.statistics.message_count == len(linear) == len(indexed)
    assert json.loads(metadata.metadata["summary"]) == json.loads(json.dumps(summary))
    counts = Counter(channel.topic for _, channel, _ in indexed)
    ticks = summary["ticks"]
    assert [counts[topic] for topic in ("/observations", "/beacons", "/commands")] == [ticks] * 3
    assert counts["/tf"] == counts["/report"] == counts["/robot/9/state"] == 1 + (ticks - 1 + 4) // 5
    assert {f"/link/{a}-{b}/state" for a, b, *_ in summary["edges"]} <= counts.keys()


def test_messages_stand_in_canonical_order_with_simulated_times(recorded: Recorded) -> None:
    path, summary = recorded
    order = [
        "/observations",
        "/beacons",
        "/commands",
        "/events",
        "/log",
        "/report",
        "/tf",
        "/scene",
        "/robot",
        "/link",
    ]
    with path.open("rb") as file:
        result = [
            (message.log_time, next(index for index, start in enumerate(order) if channel.topic.startswith(start)))
            for _, channel, message in make_reader(file).iter_messages(log_time_order=False)
            if message.log_time > 0 and message.sequence < summary["ticks"]
        ]
    assert result == sorted(result)
    assert {time % 20_000_000 for time, _ in result} == {0}  # ticks of 20 ms


def test_a_tick_holds_every_robots_messages_as_they_cross_the_bus(recorded: Recorded) -> None:
    path, _ = recorded
    decoders = {
        "/observations": messages.decode_observation,
        "/beacons": messages.decode_beacon,
        "/commands": messages.decode_command,
    }
    for topic, tick, payload in recordings.messages(path):
        if topic in decoders and tick % 100 == 0:
            result: list[Any] = [decoders[topic](message) for message in recordings.payloads(payload)]
            assert [(message.tick, message.robot) for message in result] == [(tick, robot) for robot in range(10)]


def test_json_in_a_log_has_only_finite_numbers_and_all_required_fields(recorded: Recorded) -> None:
    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    with recorded[0].open("rb") as file:
        result = list(make_reader(file).iter_messages())
    assert {channel.message_encoding for _, channel, _ in result} == {"json", "protobuf"}
    for schema, channel, message in result:
        if channel.message_encoding != "json":
            continue
        assert channel.topic in ("/scenario", "/events")
        assert schema is not None
        rules = json.loads(schema.data)
        content = json.loads(message.data, parse_constant=refuse)
        assert set(rules["required"]) <= content.keys() <= rules["properties"].keys()


def test_frames_turn_as_the_robots_do(recorded: Recorded) -> None:
    path, summary = recorded
    payloads = {(topic, tick): payload for topic, tick, payload in recordings.messages(path)}
    tick = summary["ticks"] - 1
    transforms = FrameTransforms.FromString(payloads["/tf", tick]).transforms
    sensed = [messages.decode_observation(one) for one in recordings.payloads(payloads["/observations", tick])]
    for transform, observation in zip(transforms, sensed, strict=True):
        frames = (transform.parent_frame_id, transform.child_frame_id)
        assert frames == ("map", f"robot_{observation.robot}/base_link")
        translation, rotation = transform.translation, transform.rotation
        x, y, heading = observation.pose
        assert (translation.x, translation.y, translation.z) == (x, y, 0.0)
        assert (rotation.x, rotation.y) == (0.0, 0.0)
        # the rotation by a unit quaternion (0, 0, z, w) takes x to (w^2 - z^2, 2 w z)
        z, w = rotation.z, rotation.w
        assert (w * w - z * z, 2.0 * w * z) == pytest.approx((math.cos(heading), math.sin(heading)), abs=1e-12)


def test_a_scheduled_change_is_logged_as_an_event(tmp_path: Path) -> None:
    event = [{"at": 0.5, "set": {"channel.reference_snr": 5e6}}]
    jump = load("pair.toml", run__duration=1.0, event=event)
    recordings.record(tmp_path / "run.mcap", jump)
    said = [json.loads(data) for topic, _, data in recordings.messages(tmp_path / "run.mcap") if topic == "/events"]
    assert said == [
        {"tick": 25, "what": "set", "by": "schedule", "path": "channel.reference_snr", "value": 5e6},
        {"tick": 50, "what": "end"},
    ]


def test_a_file_that_cannot_be_written_is_reported_once_and_closed() -> None:
    file = McapFile(Path("/dev/full"))
    file.put("/x", messages_pb2.Report, b"payload", 0, 0)
    with pytest.raises(FesError, match=r"^cannot write /dev/full: No space left on device$"):
        file.settle(at_once=True)
    for _ in range(3):
        file.put("/x", messages_pb2.Report, bytes(1000), 0, 0)
        file.settle(at_once=True)
    file.finish("end", {})
    assert file._waiting <= len(b"payload") + 31  # what cannot be written is not kept either
    assert file._file.closed


def test_a_log_is_read_back_with_its_run(recorded: Recorded) -> None:
    path, summary = recorded
    loaded = log.load(path)
    assert (loaded.name, loaded.backend, loaded.ended) == (summary["scenario"], "inprocess", "at its end")
    assert loaded.scenario == scenario(summary["scenario"])
    assert loaded.complaint is None
    assert loaded.summary == json.loads(json.dumps(summary))
