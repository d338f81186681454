"""Faults have one digest: in one loop, stacked, over Zenoh in any crews, and reexecuted from a log."""

from pathlib import Path
from typing import Any

import pytest

from console.backends import inprocess, stacked
from console.replay import command as replay_command
from console.replay import compare, log
from tests.support import recordings, session
from tests.support.loop import load
from tests.support.results import alone, without_wall_clock
from world.config.scenario import Scenario
from world.execution.recorder import Recorder

HALVES = [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]
FAULTS: dict[str, list[dict[str, Any]]] = {
    "hang": [{"at": 0.4, "hang": [4, 6]}, {"at": 1.2, "wake": [4]}, {"at": 1.6, "wake": [6]}],
    "all hang": [{"at": 0.4, "hang": list(range(10))}, {"at": 0.6, "wake": list(range(10))}],
    "partition": [
        {"at": 0.6, "set": {"channel.partition": HALVES}},
        {"at": 1.4, "set": {"channel.partition": []}},
    ],
    "loss": [{"at": 0.2, "transmitter": {"robot": 4, "loss": 0.7}}],
    "delay": [
        {"at": 0.0, "transmitter": {"robot": 4, "delay": 0.1}},
        {"at": 0.2, "transmitter": {"robot": 5, "delay": 0.3}},
        {"at": 1.2, "transmitter": {"robot": 5}},
    ],
    "corrupt": [
        {"at": 0.1, "transmitter": {"robot": 5, "corrupt": True}},
        {"at": 1.2, "transmitter": {"robot": 5}},
    ],
    "skew": [{"at": 0.3, "clock": {"robot": 4, "skew": 0.05}}, {"at": 1.2, "clock": {"robot": 4}}],
}
FAULTS["together"] = [
    *FAULTS["hang"],
    *FAULTS["partition"],
    *FAULTS["corrupt"],
    *FAULTS["skew"],
    {"at": 0.2, "transmitter": {"robot": 4, "delay": 0.3, "loss": 0.2}},
    {"at": 0.2, "transmitter": {"robot": 2, "delay": 0.2}},
    {"at": 0.8, "kill": [0]},
    {"at": 1.8, "restart": [0]},
]
CREWS = {"one": [[i] for i in range(10)], "many": [[3, 4, 5], [0, 1, 2, 6, 7, 8, 9]]}


def faulty(name: str, fault: str) -> Scenario:
    return load(name, run__duration=2.4, event=FAULTS[fault])


@pytest.mark.parametrize("crew", CREWS)
@pytest.mark.parametrize(
    ("name", "fault"),
    [*(("measured.toml", fault) for fault in FAULTS), ("paper.toml", "together")],
)
def test_each_fault_has_a_digest_of_its_own_equal_in_one_loop_and_over_zenoh(
    name: str, fault: str, crew: str
) -> None:
    scenario = faulty(name, fault)
    summary, server, agents = session.finished(scenario, CREWS[crew])
    assert summary["digest"] == inprocess.run(scenario, "test")["digest"]
    assert summary["digest"] != inprocess.run(load(name, run__duration=2.4), "calm")["digest"]
    if fault == "all hang" and crew == "many":
        return  # no robot holds the world up, so it runs ahead of crews, which drop observations that they missed
    assert not server.drops.counts
    counts = {robot: agent.drops.counts for agent in agents for robot in agent._robots}
    if FAULTS["corrupt"][0] not in FAULTS[fault]:
        assert not any(counts.values())
        return
    # from tick 5 to 59 each peer of robot 5 in range gets 55 damaged beacons, less those while it is absent
    for robot in (2, 7, 8, 9):
        assert all(kind.startswith("Beacon: ") for kind in counts[robot])
        assert 30 <= sum(counts[robot].values()) <= 55 * (1 if crew == "one" else 10)
    assert sum(counts[9].values()) == 55
    if crew == "one":
        assert not counts[5]


@pytest.mark.parametrize("name", ["measured.toml", "paper.toml"])
@pytest.mark.parametrize("fault", FAULTS)
def test_stacked_runs_with_faults_have_the_summaries_that_they_have_alone(name: str, fault: str) -> None:
    scenarios = [load(name, run__seed=seed, run__duration=2.4, event=FAULTS[fault]) for seed in (3, 0)]
    result = [without_wall_clock(summary) for summary in stacked.run(scenarios, "x")]
    assert result == alone(scenarios)


def test_runs_with_different_faults_are_not_stacked_and_teams_of_different_sizes_are() -> None:
    late = {"at": 0.2, "transmitter": {"robot": 2, "delay": 0.1}, "clock": {"robot": 1, "skew": 0.05}}
    lossy = {"at": 0.2, "transmitter": {"robot": 2, "loss": 0.5}}
    small = {"seeking__index": "measured", "run__duration": 2.0, "robots__jitter": 5.0}
    of = {
        (count, number): load("hundred.toml", robots__count=count, event=[event], **small)
        for count in (3, 7)
        for number, event in enumerate((late, lossy))
    }
    assert stacked.alike(of[3, 0]) == stacked.alike(of[7, 0]) != stacked.alike(of[7, 1])
    together = [of[7, 0], of[3, 0], of[7, 0]]
    assert [without_wall_clock(summary) for summary in stacked.run(together, "x")] == alone(together)


@pytest.mark.parametrize("fault", ["together", "all hang"])
def test_a_log_of_faults_is_executed_again_and_is_the_same_from_one_loop_and_over_zenoh(
    fault: str, tmp_path: Path
) -> None:
    scenario = faulty("measured.toml", fault)
    recordings.record(tmp_path / "loop.mcap", scenario)
    with Recorder(tmp_path / "bus.mcap", scenario, "test", "processes") as recorder:
        summary, *_ = session.finished(scenario, CREWS["one"], recorder)
        recorder.conclude(summary)
    loop, over = (log.load(tmp_path / name) for name in ("loop.mcap", "bus.mcap"))
    assert compare.first_difference(loop, over) is None
    for result in (loop, over):
        assert replay_command.rerun(result, all_robots=True)["digest"] == summary["digest"]
        assert [replay_command.rerun_robot(result, robot) for robot in (0, 4, 5)] == [120] * 3


def test_a_damaged_beacon_is_an_empty_payload_in_the_log(tmp_path: Path) -> None:
    recordings.record(tmp_path / "run.mcap", faulty("measured.toml", "corrupt"))
    empty = [
        [robot for robot, beacon in enumerate(tick.payloads.beacons) if not beacon]
        for tick in log.load(tmp_path / "run.mcap").ticks()
    ]
    assert empty == [[]] * 5 + [[5]] * 55 + [[]] * 60
