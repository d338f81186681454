"""Tampered logs: one line names the fault, whether they are executed, shown or drawn."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.analysis import command as analysis_command
from console.replay import command as replay_command
from console.replay import compare, log
from console.replay.log import Log
from console.replay.player import Player
from fes.arrays.types import Floats
from fes.errors import FesError
from fes.protocol import messages
from fes.protocol.report import decode_report, encode_report
from fes.recording import messages_pb2
from tests.support import recordings
from tests.support.loop import load
from tests.support.recordings import Edit
from world.simulation import truth
from world.simulation.truth import State, World

HALVED = {"at": 0.2, "set": {"channel.reference_snr": 5e6}}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two robots for a second; after a fifth of it the channel changes."""
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    recordings.record(path, load("pair.toml", run__duration=1.0, event=[HALVED]))
    return path


def on(topic: str, tick: int, change: Callable[[bytes], bytes | None]) -> Edit:
    """An edit of one topic's message at one tick."""
    return lambda result, number, data: change(data) if (result, number) == (topic, tick) else data


def team(change: Callable[[list[bytes]], list[bytes]], tick: int | None = 10) -> Callable[[bytes], bytes]:
    """A change of the payloads in a message of all robots; `tick` replaces its tick, and None removes it."""

    def changed(data: bytes) -> bytes:
        return bytes(messages_pb2.Commands(tick=tick, payloads=change(recordings.payloads(data))).SerializeToString())

    return changed


def same(payloads: list[bytes]) -> list[bytes]:
    return payloads


def peers(payload: bytes) -> bytes:
    observation = messages.decode_observation(payload)
    return messages.encode_observation(observation._replace(in_range=observation.in_range + 7))


def links(payload: bytes) -> bytes:
    command = messages.decode_command(payload)
    return messages.encode_command(command._replace(links=np.array([7]), estimates=np.ones(1), learnt=np.zeros(0)))


def told(**changes: Any) -> Callable[[bytes], bytes]:
    return lambda data: json.dumps(json.loads(data) | changes).encode()


ALL, ALONE, WORLD = ("alone", "again", "player", "plot"), ("alone",), ("again", "player", "plot")

WRONG: dict[str, tuple[Edit, str, tuple[str, ...]]] = {
    "one payload fewer": (on("/beacons", 10, team(lambda all_: all_[:-1])), "tick 10: /beacons has 1 payloads", ALL),
    "one payload more": (on("/commands", 10, team(lambda all_: [*all_, all_[0]])), "tick 10: /commands has 3", ALL),
    "another tick": (on("/beacons", 10, team(same, 11)), "tick 10: the message on /beacons is of tick 11", ALL),
    "two messages": (on("/observations", 10, team(same, 9)), "tick 9 has two messages on /observations", ALL),
    "no tick": (on("/observations", 10, team(same, None)), "a message on /observations has no tick", ALL),
    "no message": (on("/commands", 10, lambda data: None), "tick 10 has no message on /commands", ALL),
    "a peer that is not": (
        recordings.edited("/observations", 10, 1, peers),
        r"^tick 10, robot 1: Observation: names a robot that is not one of 2: \[7\]",
        ALONE,
    ),
    "a link that is not": (
        recordings.edited("/commands", 10, 1, links),
        r"^tick 10, robot 1: Command: names a robot that is not one of 2: \[7\]",
        WORLD,
    ),
    "a report without payload": (on("/report", 10, lambda data: b""), "tick 10: Report: ", ALL),
    "no report": (on("/report", 10, lambda data: None), "^tick 10: the Report that is due is not in the log", WORLD),
    "no last report": (on("/report", 49, lambda data: None), "^tick 49: the Report that is due is not", WORLD),
    "no reports": (lambda topic, tick, data: None if topic == "/report" else data, "^tick 0: the Report", WORLD),
    "another report": (
        on("/report", 10, lambda data: farther(data)),
        r"^tick 10, Report: poses\[0\] is .* in the log and .* executed again",
        WORLD,
    ),
    "nothing scheduled": (on("/events", 10, lambda data: None), "^tick 10, events: what was scheduled is", WORLD),
    "something else scheduled": (
        on("/events", 10, told(value=4e6)),
        "^tick 10, events: what was scheduled is",
        WORLD,
    ),
    "an end too early": (lambda topic, tick, data: data if tick <= 30 else None, "31 ticks are there, and its", ALL),
    "a scenario that is not text": (
        on("/scenario", 0, told(scenario=7)),
        "what it says of its run cannot be read",
        ALL,
    ),
    "a deep scenario": (on("/scenario", 0, lambda data: b"[" * 100_000), "it does not begin with its scenario", ALL),
    "a deep event": (on("/events", 10, lambda data: b"[" * 100_000), "it is nested too deeply", ALL),
    "an event that is a list": (on("/events", 10, lambda data: b"[]"), "is not what its topic promises", ALL),
}


def farther(data: bytes) -> bytes:
    """A Report with robot 0 elsewhere."""
    payload = messages_pb2.Report.FromString(data).payload
    decoded = decode_report(payload)
    report = encode_report(decoded)
    position = report.index(decoded.poses.tobytes())
    moved = decoded.poses + 1.0
    payload = report.replace(report[position : position + moved.nbytes], moved.tobytes())
    return bytes(messages_pb2.Report(payload=payload).SerializeToString())


def shown(found: Log) -> None:
    """Show the dashboard to the end of the log."""
    screen = Player(found, 1e6)
    while screen.playing:
        screen.advance(1.0)


def execute(how: str, path: Path, out: Path) -> None:
    if how == "plot":
        analysis_command.plot(str(path), out=out)
    elif how == "alone":
        replay_command.rerun_robot(log.load(path), 1)
    elif how == "again":
        replay_command.rerun(log.load(path))
    else:
        shown(log.load(path))


@pytest.mark.parametrize("what", WRONG)
def test_a_tampered_log_is_rejected_in_one_line(recorded: Path, tmp_path: Path, what: str) -> None:
    edit, rule, noticed = WRONG[what]
    path = tmp_path / "run.mcap"
    recordings.rewrite(recorded, path, edit)
    for how in noticed:
        with pytest.raises(FesError, match=rule) as caught:
            execute(how, path, tmp_path)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("how", WORLD)
@pytest.mark.parametrize("key", ["digest", "beacons_sent", "extra"])
def test_every_reexecution_names_a_summary_that_the_log_does_not_yield(
    recorded: Path, tmp_path: Path, how: str, key: str
) -> None:
    summary = log.load(recorded).summary
    assert summary is not None
    recordings.rewrite(recorded, tmp_path / "run.mcap", lambda topic, tick, data: data, {**summary, key: 0})
    with pytest.raises(FesError, match=rf"^summary: {key} is 0 in the log and "):
        execute(how, tmp_path / "run.mcap", tmp_path)


@pytest.mark.parametrize(
    ("edit", "summary", "expected"),
    [
        (on("/report", 10, lambda data: farther(data)), None, (10, "Report", "poses[0]")),
        (on("/report", 10, lambda data: None), None, (10, "Report", "payload")),
        (on("/events", 10, told(value=4e6)), None, (10, "events", "what was set")),
        (on("/events", 10, told(by="person")), None, None),
        (on("/scenario", 0, told(backend="processes")), {"wall_s": 7.0, "scenario": "x"}, None),
        (on("/scenario", 0, told()), {"digest": "0"}, (49, "summary", "digest")),
    ],
)
def test_compare_checks_reports_changes_and_the_summary(
    recorded: Path, tmp_path: Path, edit: Edit, summary: dict[str, Any] | None, expected: Any
) -> None:
    original = log.load(recorded)
    recordings.rewrite(recorded, tmp_path / "run.mcap", edit, (original.summary or {}) | (summary or {}))
    difference = compare.first_difference(original, log.load(tmp_path / "run.mcap"))
    assert (difference and (difference.tick, difference.message, difference.field)) == expected


def test_compare_checks_messages_first_and_finds_a_missing_end(recorded: Path, tmp_path: Path) -> None:
    original = log.load(recorded)
    recordings.rewrite(recorded, tmp_path / "killed.mcap", lambda topic, tick, data: data, ended=False)
    difference = compare.first_difference(original, log.load(tmp_path / "killed.mcap"))
    assert difference is not None
    assert difference.describe("in A", "in B") == "tick 49, end: how it ended is 'at its end' in A and 'nothing' in B"

    def both(topic: str, tick: int, data: bytes) -> bytes | None:
        moved = recordings.edited("/commands", 40, 1, links)(topic, tick, data)
        return None if moved is None else on("/events", 10, told(value=4e6))(topic, tick, moved)

    recordings.rewrite(recorded, tmp_path / "both.mcap", both)
    difference = compare.first_difference(original, log.load(tmp_path / "both.mcap"))
    assert difference is not None
    assert (difference.tick, difference.message, difference.robot) == (40, "Command", 1)


def test_an_untouched_log_passes_every_check(recorded: Path, tmp_path: Path) -> None:
    recordings.rewrite(recorded, tmp_path / "run.mcap", lambda topic, tick, data: data)
    for how in ALL:
        execute(how, tmp_path / "run.mcap", tmp_path)


def test_reexecution_of_the_world_ends_with_the_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recordings.record(tmp_path / "run.mcap", load("pair.toml", run__duration=1.0, event=[HALVED]))
    step, stepped = truth.step, list[int]()

    def counted(world: World, state: State, twists: Floats) -> State:
        stepped.append(state.tick)
        return step(world, state, twists)

    monkeypatch.setattr(truth, "step", counted)
    assert replay_command.rerun(log.load(tmp_path / "run.mcap"))["ticks"] == 50
    assert stepped == list(range(49))  # the twists of tick 49 lead to a tick that is not in the log
