"""Faulty transmitters, clocks that jump and a parted team: each has its described effect, and no other."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.control import clocks, transmitter
from agents.runtime import marshalling
from console.backends import inprocess
from console.backends.inprocess import Tick
from fes.errors import MessageError, ScenarioError
from fes.extension.context import SeededDraws
from fes.model import config
from fes.model.sensing import DECODED, LOST
from fes.protocol import messages
from tests.support.loop import load
from world.config import scenario as scenarios
from world.config.radio import RadioConfig
from world.config.scenario import Scenario, agent_config
from world.metrics.summary import write_scenario

Event = dict[str, Any]
PERFECT: dict[str, Any] = {"channel__model": "perfect"}
HALVES = [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]


def ticks(*events: Event, seconds: float = 3.0, name: str = "neighborhood.toml", **more: Any) -> list[Tick]:
    return list(inprocess.ticks(load(name, run__duration=seconds, event=list(events), **more)))


def verdicts(tick: Tick, sender: int) -> set[int]:
    """Verdicts on the beacons that a robot sent at the tick before."""
    radio = tick.state.radio
    return set(radio.reception[(radio.edges.peers == sender) & (radio.age > 2)].tolist())


def test_a_transmitter_loses_its_share_of_its_own_beacons_at_every_receiver() -> None:
    run = ticks({"at": 1.0, "transmitter": {"robot": 3, "loss": 0.4}}, seconds=21.0, **PERFECT)
    before, after = run[50].state.radio, run[-1].state.radio
    assert before.decoded.tolist() == before.sent.tolist()
    positions = after.edges.after(before.edges).positions
    stayed = positions >= 0
    sent, decoded = (
        getattr(after, name)[stayed] - getattr(before, name)[positions[stayed]] for name in ("sent", "decoded")
    )
    for sender in range(10):
        mine = after.edges.peers[stayed] == sender
        assert sent[mine].sum() >= 3900
        share = decoded[mine].sum() / sent[mine].sum()
        # a standard deviation of 0.0077 at most
        assert share == (pytest.approx(0.6, abs=0.04) if sender == 3 else 1.0)


def test_a_damaging_transmitter_reaches_no_robot_until_it_is_healed() -> None:
    run = ticks(
        {"at": 1.0, "transmitter": {"robot": 3, "corrupt": True}}, {"at": 2.0, "transmitter": {"robot": 3}}, **PERFECT
    )
    assert [verdicts(tick, 3) for tick in run[3:]] == [{DECODED}] * 48 + [{LOST}] * 50 + [{DECODED}] * 49
    assert all(verdicts(tick, sender) == {DECODED} for tick in run[3:] for sender in range(10) if sender != 3)


@pytest.mark.parametrize("name", ["neighborhood.toml", "measured.toml"])
def test_a_late_transmitter_sends_old_data_and_its_oldest_until_the_delay_has_passed(name: str) -> None:
    late = {"at": 0.2, "transmitter": {"robot": 3, "delay": 0.1}}
    longer, healed = {"at": 0.6, "transmitter": {"robot": 3, "delay": 0.2}}, {"at": 1.0, "transmitter": {"robot": 3}}
    run = ticks(late, longer, healed, seconds=1.5, name=name)

    def given(tick: int) -> tuple[bytes, ...]:
        now, telemetry = run[tick], run[tick].telemetry
        span = telemetry.links.spans[3]
        return (
            now.state.poses[3].tobytes(),
            telemetry.links.peers[span].tobytes(),
            telemetry.estimates[span].tobytes(),
        )

    def sent(tick: int, robot: int = 3) -> tuple[bytes, ...]:
        beacons = run[tick].beacons
        span = beacons.links.spans[robot]
        return beacons.poses[robot].tobytes(), beacons.links.peers[span].tobytes(), beacons.estimates[span].tobytes()

    then = [*range(10), *[10] * 6, *range(11, 25), *[24] * 5, *range(25, 40), *range(50, 75)]
    assert len(then) == len(run)
    for tick, was in enumerate(then):
        assert sent(tick) == given(was), tick
        assert run[tick].beacons.poses[4].tobytes() == run[tick].state.poses[4].tobytes()
    assert sent(20) != given(20)


def test_measurements_are_late_too_and_commands_are_not() -> None:
    calm = ticks(seconds=1.0, name="measured.toml")
    run = ticks({"at": 0.4, "transmitter": {"robot": 3, "delay": 0.2}}, seconds=1.0, name="measured.toml")
    first = 24  # the first tick at which its own late beacons can affect robot 3 through its peers
    assert run[first].beacons.statistics[3].tobytes() == calm[20].beacons.statistics[3].tobytes()
    assert run[first].beacons.statistics[3].tobytes() != calm[first].beacons.statistics[3].tobytes()
    spoken = {robot: payloads for robot, *payloads in marshalling.encode_tick(run[first].beacons, *told(run[first]))}
    beacon, command = messages.decode_beacon(spoken[3][0]), messages.decode_command(spoken[3][1])
    assert beacon.tick == command.tick == first
    own = run[first].telemetry.links.rows == 3
    assert command.estimates.tolist() == run[first].telemetry.estimates[own].tolist()


def told(tick: Tick) -> tuple[Any, Any]:
    return tick.twists, tick.telemetry


def test_a_robot_that_rejoins_has_no_old_data_to_send() -> None:
    away = [{"at": 0.8, "hang": [3]}, {"at": 1.2, "wake": [3]}]
    run = ticks({"at": 0.2, "transmitter": {"robot": 3, "delay": 0.1}}, *away, seconds=2.0)
    for tick in range(60, 66):
        assert run[tick].beacons.poses[3].tobytes() == run[60].state.poses[3].tobytes()
    assert run[70].beacons.poses[3].tobytes() == run[65].state.poses[3].tobytes()


def test_a_clock_that_jumps_affects_its_robot_alone_from_its_tick_on() -> None:
    calm = ticks(seconds=2.0, name="measured.toml")
    run = ticks({"at": 1.0, "clock": {"robot": 4, "skew": 5.0}}, seconds=2.0, name="measured.toml")
    for tick in range(50):
        assert run[tick].twists.tobytes() == calm[tick].twists.tobytes()
    others = [robot for robot in range(10) if robot != 4]
    assert run[50].twists[others].tobytes() == calm[50].twists[others].tobytes()
    assert run[50].twists[4].tolist() != calm[50].twists[4].tolist()


@pytest.mark.parametrize("name", ["paper.toml", "measured.toml"])
def test_clocks_set_to_their_drawn_skews_give_the_same_digest(name: str) -> None:
    skewed = load(name, run__duration=2.0, run__clock_skew=0.05)
    config = agent_config(skewed)
    drawn = clocks.of(config, np.arange(10), SeededDraws(config.seed)).initial.tolist()
    jumps = [{"at": 0.0, "clock": {"robot": robot, "skew": skew}} for robot, skew in enumerate(drawn)]
    by_hand = load(name, run__duration=2.0, event=jumps)
    right = inprocess.run(load(name, run__duration=2.0), name)["digest"]
    assert inprocess.run(by_hand, name)["digest"] == inprocess.run(skewed, name)["digest"] != right
    again = [{"at": 0.5, "clock": {"robot": 3, "skew": 1.0}}, {"at": 0.5, "clock": {"robot": 3}}]
    healed = load(name, run__duration=2.0, run__clock_skew=0.05, event=again)
    assert inprocess.run(healed, name)["digest"] == inprocess.run(skewed, name)["digest"]


def test_no_beacon_decodes_between_two_groups_and_within_one_nothing_changes() -> None:
    calm = ticks(seconds=3.0)
    parted = [{"at": 1.0, "set": {"channel.partition": [HALVES[0]]}}, {"at": 2.0, "set": {"channel.partition": []}}]
    run = ticks(*parted, seconds=3.0)  # robots in no group form one
    for number in (50, 51, 60, 100):
        radio, was = run[number].state.radio, calm[number].state.radio
        across = (radio.edges.ids[radio.edges.rows] < 5) != (radio.edges.peers < 5)
        assert across.any()
        heard = set(radio.reception[across].tolist())
        assert heard == {LOST} if number > 50 else heard == {LOST, DECODED}
        if number == 51:  # sent from the same positions, with the same draws
            assert radio.reception[~across].tolist() == was.reception[~across].tolist()
            assert radio.probability[across].tolist() == [0.0] * int(across.sum())
    radio = run[110].state.radio
    across = (radio.edges.ids[radio.edges.rows] < 5) != (radio.edges.peers < 5)
    assert DECODED in radio.reception[across]


def test_a_hung_robot_is_like_a_dead_one_to_its_peers() -> None:
    hung = load("paper.toml", run__duration=4, event=[{"at": 1.0, "hang": [4, 6]}, {"at": 2.4, "wake": [4]}])
    dead = load("paper.toml", run__duration=4, event=[{"at": 1.0, "kill": [4, 6]}, {"at": 2.4, "restart": [4]}])
    calm = load("paper.toml", run__duration=4)
    digests = [inprocess.run(scenario, "x")["digest"] for scenario in (hung, dead, calm)]
    assert digests[0] == digests[1] != digests[2]


def test_damaged_beacons_are_none_and_are_damaged_in_three_ways_each_time_the_same() -> None:
    lengths, broken = set(), []
    for tick in ticks(seconds=4.0, name="measured.toml"):
        for robot, beacon, _ in marshalling.encode_tick(tick.beacons, *told(tick)):
            damaged = transmitter.damage(7, tick.state.tick, robot, beacon)
            assert damaged == transmitter.damage(7, tick.state.tick, robot, beacon)
            with pytest.raises(MessageError):
                messages.decode_beacon(damaged)
            broken.append((beacon, damaged))
            lengths.add(len(damaged) == len(beacon))
    assert lengths == {True, False}
    complete = [pair for pair in broken if len(pair[0]) == len(pair[1])]
    same = [sum(a == b for a, b in zip(*pair, strict=True)) / len(pair[0]) for pair in complete]
    assert min(same) < 0.1
    assert max(same) > 0.9
    assert len({damaged for _, damaged in broken}) > 0.95 * len(broken)


def test_an_agent_receives_the_faults_of_its_own_robots_only_and_no_losses() -> None:
    faulty = load(
        "paper.toml",
        event=[
            {"at": 1.0, "transmitter": {"robot": 3, "loss": 0.5}},
            {"at": 2.0, "transmitter": {"robot": 3, "delay": 0.2}, "clock": {"robot": 3, "skew": 0.1}},
            {"at": 1.5, "transmitter": {"robot": 5, "corrupt": True}},
        ],
    )
    whole = agent_config(faulty)
    result = [(fault.tick, fault.robot, fault.delay, fault.corrupt, fault.skew) for fault in whole.faults]
    assert result == [(75, 5, 0, True, None), (100, 3, 10, False, None), (100, 3, 10, False, 0.1)]
    assert [fault.robot for fault in config.own(whole, (3, 4)).faults] == [3, 3]
    assert config.own(whole, (0,)).faults == []
    again = messages.decode_welcome(messages.encode_welcome(messages.Welcome((3,), whole)))
    assert again.config == whole


@pytest.mark.parametrize(
    ("events", "rule"),
    [
        ([{"at": 1.0, "hang": [10]}], "hang: robot 10 does not exist: there are only 10"),
        ([{"at": 1.0, "kill": [1]}, {"at": 2.0, "hang": [1]}], "hang: robot 1 is dead at 2 s"),
        ([{"at": 1.0, "hang": [1]}, {"at": 2.0, "kill": [1]}], "kill: robot 1 is hung at 2 s"),
        ([{"at": 1.0, "hang": [1]}, {"at": 2.0, "restart": [1]}], "restart: robot 1 is hung at 2 s"),
        ([{"at": 1.0, "hang": [1]}, {"at": 2.0, "hang": [1]}], "hang: robot 1 is hung already at 2 s"),
        ([{"at": 1.0, "wake": [1]}], "wake: robot 1 is alive already at 1 s"),
        ([{"at": 1.0, "hang": [1, 1]}], "robot 1 must be named once, but is in hang and in hang"),
        ([{"at": 1.0, "hang": [1]}, {"at": 1.001, "wake": [1]}], "wake: robot 1 leaves and rejoins in one tick"),
        ([{"at": 1.0, "transmitter": {"robot": 10}}], "transmitter: robot 10 does not exist: there are only 10"),
        ([{"at": 1.0, "transmitter": {"loss": 0.5}}], "transmitter.robot: is required"),
        ([{"at": 1.0, "transmitter": {"robot": 1, "delay": -0.1}}], "delay: must be greater than or equal to 0"),
        (
            [{"at": 1.0, "transmitter": {"robot": 1, "delay": 0.001}}],
            "delay must be 0, or from run.dt to 10000 ticks",
        ),
        ([{"at": 1.0, "transmitter": {"robot": 1, "delay": 201.0}}], "0.02 to 200 s, got 201"),
        ([{"at": 1.0, "transmitter": {"robot": 1, "loss": 1.1}}], "loss: must be less than or equal to 1, got 1.1"),
        ([{"at": 1.0, "transmitter": {"robot": 1, "noise": 1.0}}], "unknown field 'event.0.transmitter.noise'"),
        ([{"at": 1.0, "clock": {"robot": 10, "skew": 0.1}}], "clock: robot 10 does not exist: there are only 10"),
        ([{"at": 1.0, "clock": {"robot": 1, "skew": 11.0}}], "skew: must be less than or equal to 10, got 11"),
        ([{"at": 1.0, "set": {"channel.partition": [[0, 10]]}}], "channel.partition: robot 10 does not exist"),
        ([{"at": 1.0, "set": {"channel.partition": [[0, 1], [1]]}}], "partition: robot 1 is listed twice"),
        ([{"at": 1.0, "set": {"channel.partition": [0, 1]}}], "partition.0: must be a valid list, got 0"),
    ],
)
def test_an_impossible_fault_is_rejected_in_one_line(events: list[Event], rule: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load("paper.toml", event=events)
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_partition_is_checked_at_the_start_and_when_it_is_set() -> None:
    with pytest.raises(ScenarioError, match="robot 2 does not exist: there are only 2"):
        load("pair.toml", channel__partition=[[0], [2]])
    with pytest.raises(ScenarioError, match="robot 2 does not exist: there are only 2"):
        scenarios.with_event(load("pair.toml"), 10, "channel.partition", [[0], [2]])
    assert not RadioConfig(model="perfect", partition=[[0]]).is_certain


def test_a_scenario_with_every_fault_is_the_same_after_writing_and_reading(tmp_path: Path) -> None:
    faulty: Scenario = load(
        "paper.toml",
        event=[
            {"at": 1.0, "hang": [1]},
            {"at": 2.0, "wake": [1]},
            {"at": 1.5, "set": {"channel.partition": HALVES}},
            {"at": 3.0, "transmitter": {"robot": 3, "loss": 0.5, "delay": 0.2, "corrupt": True}},
            {"at": 3.5, "transmitter": {"robot": 3}, "clock": {"robot": 3}},
            {"at": 4.0, "clock": {"robot": 3, "skew": -0.1}},
        ],
    )
    write_scenario(tmp_path, faulty)
    assert scenarios.load(tmp_path / "scenario.toml") == faulty
