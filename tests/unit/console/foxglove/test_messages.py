"""The topics of an observer: those of a log, as far as a Report suffices for them."""

from pathlib import Path

import numpy as np
import pytest
from google.protobuf.message import Message
from mcap.reader import make_reader

from console.foxglove import messages
from fes.protocol.report import decode_report
from fes.recording.messages_pb2 import Report, RobotState
from tests.support import foxglove_layout
from tests.support.foxglove_client import message_type
from tests.support.frames import a_report
from tests.support.loop import load
from tests.support.recordings import record
from world.execution.recorder import MAX_VIEWED

ONLY_IN_A_LOG = {"/scenario", "/observations", "/beacons", "/commands", "/events", "/log"}


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of the paper's ten robots."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    record(path, load("paper.toml", run__duration=2.0))
    return path


def by_tick(path: Path) -> dict[int, list[tuple[str, bytes]]]:
    """Topics and payloads of a log, tick by tick, in its order."""
    ticks: dict[int, list[tuple[str, bytes]]] = {}
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            ticks.setdefault(message.sequence, []).append((channel.topic, message.data))
    return ticks


def is_only_in_a_log(topic: str) -> bool:
    return topic in ONLY_IN_A_LOG or topic.startswith("/robot/")


def test_an_observer_has_the_messages_of_the_log_byte_for_byte_and_in_its_order(path: Path) -> None:
    ticks = by_tick(path)
    compared = 0
    for tick, logged in ticks.items():
        for payload in [data for topic, data in logged if topic == "/report"]:
            report = decode_report(Report.FromString(payload).payload)
            of_tick = [*(messages.bodies(report) if tick == 0 else ()), *messages.of_report(report)]
            observed = [(topic, message.SerializeToString()) for topic, message in of_tick]
            assert observed == [(topic, data) for topic, data in logged if not is_only_in_a_log(topic)]
            compared += 1
    assert compared == 21  # 0.1 s apart, and the last tick


def test_the_layout_names_topics_and_fields_of_the_log_and_of_an_observer(path: Path) -> None:
    recorded: dict[str, type[Message]] = {}
    observed: dict[str, type[Message]] = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            if schema.encoding == "protobuf" and channel.topic not in recorded:
                recorded[channel.topic] = message_type(schema.name, schema.data)
            if channel.topic == "/report":
                report = decode_report(Report.FromString(message.data).payload)
                topics = (*messages.bodies(report), *messages.of_report(report))
                observed |= {topic: type(message) for topic, message in topics}
    assert len(foxglove_layout.message_paths()) >= 10
    assert foxglove_layout.unknown(recorded) == foxglove_layout.unknown(observed) == []


def test_the_check_of_the_layout_finds_an_unknown_topic_and_an_unknown_field() -> None:
    unknown = foxglove_layout.unknown({"/report": Report})
    assert "/tf" in unknown
    assert "/link/0-1/state.separation" in unknown
    assert "/report.disagreement" not in unknown
    assert "/report.disagreement" in foxglove_layout.unknown({"/report": RobotState})


def test_the_layout_shows_each_of_its_panels_in_one_place() -> None:
    table = foxglove_layout.layout()

    def shown(node: str | dict[str, object]) -> list[str]:
        if isinstance(node, str):
            return [node]
        return shown(node["first"]) + shown(node["second"])  # type: ignore[arg-type]

    assert sorted(shown(table["layout"])) == sorted(table["configById"])


@pytest.mark.parametrize(("robots", "is_viewed"), [(MAX_VIEWED, True), (MAX_VIEWED + 1, False)])
def test_a_team_too_large_for_the_topics_of_viewers_has_the_report_alone(robots: int, is_viewed: bool) -> None:
    report = a_report([(float(x), 0.0) for x in np.arange(robots)])
    topics = [topic for topic, _ in (*messages.bodies(report), *messages.of_report(report))]
    assert topics == (["/scene/robots", "/report", "/tf", "/scene/links"] if is_viewed else ["/report"])
