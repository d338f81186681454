"""Noisy sensors and bodies have one digest: in one loop, stacked, over Zenoh in any crews, resumed and replayed."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from console.backends import inprocess, stacked
from console.replay import command as replay_command
from console.replay import compare, log
from fes.protocol import messages
from tests.support import bits, recordings, session
from tests.support.loop import load
from tests.support.results import alone, without_wall_clock
from tests.support.teams import Team
from world.config.scenario import Scenario
from world.execution import resume
from world.execution.checkpoint import CheckpointWriter
from world.execution.run import Run
from world.simulation import truth

ABSENCE = [{"at": 0.6, "kill": [0]}, {"at": 1.4, "restart": [0]}]
KINDS: dict[str, dict[str, Any]] = {
    "white": {"sensing__pose_noise": 1.0, "sensing__heading_noise": 0.087, "robots__slip": 0.05},
    "slow and late": {"sensing__pose_rate": 9.0, "sensing__pose_latency": 0.1, "robots__slip": 0.05},
    "unfiltered": {"sensing__pose_noise": 1.0, "sensing__pose_rate": 9.0, "localization__filter": "none"},
}
KINDS["together"] = (
    KINDS["white"] | KINDS["slow and late"] | {"sensing__pose_drift": 0.5, "robots__actuator_lag": 0.2}
)
CREWS = {"one": [[i] for i in range(10)], "many": [[3, 4, 5], [0, 1, 2, 6, 7, 8, 9]]}


def noisy(kind: str, seed: int = 1) -> Scenario:
    return load("measured.toml", run__seed=seed, run__duration=2.0, event=ABSENCE, **KINDS[kind])


@pytest.mark.parametrize(("kind", "crew"), [*((kind, "one") for kind in KINDS), ("together", "many")])
def test_each_kind_of_noise_has_a_digest_of_its_own_equal_in_one_loop_and_over_zenoh(kind: str, crew: str) -> None:
    scenario = noisy(kind)
    summary, server, _ = session.finished(scenario, CREWS[crew])
    assert summary["digest"] == inprocess.run(scenario, "test")["digest"]
    exact = load("measured.toml", run__duration=2.0, event=ABSENCE)
    assert summary["digest"] != inprocess.run(exact, "exact")["digest"]
    assert not server.drops.counts


def test_slow_and_late_but_exact_fixes_of_bodies_that_follow_exactly_change_no_digit() -> None:
    # Dead reckoning is then the motion of the bodies itself, and each fix confirms it to the bit.
    slow = load("measured.toml", run__duration=2.0, event=ABSENCE, sensing__pose_rate=9.0, sensing__pose_latency=0.1)
    exact = load("measured.toml", run__duration=2.0, event=ABSENCE)
    assert inprocess.run(slow, "x")["digest"] == inprocess.run(exact, "x")["digest"]


@pytest.mark.parametrize("kind", KINDS)
def test_stacked_noisy_runs_have_the_summaries_that_they_have_alone(kind: str) -> None:
    scenarios = [noisy(kind, seed) for seed in (3, 0)]
    assert [without_wall_clock(summary) for summary in stacked.run(scenarios, "x")] == alone(scenarios)


def test_runs_that_differ_only_in_what_robots_are_not_told_are_stacked() -> None:
    scenarios = [load("measured.toml", run__duration=1.0, robots__slip=slip) for slip in (0.0, 0.1)]
    rated = load("measured.toml", run__duration=1.0, sensing__pose_rate=5.0, sensing__pose_drift=1.0)
    assert stacked.alike(scenarios[0]) == stacked.alike(scenarios[1]) == stacked.alike(rated)
    together = [*scenarios, rated]
    assert [without_wall_clock(summary) for summary in stacked.run(together, "x")] == alone(together)


@pytest.mark.parametrize(("kind", "matters"), [("unfiltered", False), ("white", True)])
def test_a_study_hides_a_lag_from_the_robots_which_matters_only_to_dead_reckoning(kind: str, matters: bool) -> None:
    hidden = load("measured.toml", run__duration=2.0, **KINDS[kind])
    lagging = load("measured.toml", run__duration=2.0, robots__actuator_lag=0.2, **KINDS[kind])

    def final_poses(told: Scenario | None) -> bytes:
        *_, last = stacked.ticks([lagging], None if told is None else [told])
        return last[0].state.poses.tobytes()

    assert final_poses(lagging) == final_poses(None)
    assert (final_poses(hidden) != final_poses(None)) is matters


@pytest.mark.parametrize("kind", KINDS)
def test_a_log_of_noise_is_executed_again_and_has_the_fixes_as_they_were_sensed(kind: str, tmp_path: Path) -> None:
    scenario = noisy(kind)
    summary = recordings.record(tmp_path / "run.mcap", scenario)
    recorded = log.load(tmp_path / "run.mcap")
    assert compare.first_difference(recorded, recorded) is None
    assert replay_command.rerun(recorded, all_robots=True)["digest"] == summary["digest"]
    assert [replay_command.rerun_robot(recorded, robot) for robot in (0, 4)] == [100] * 2
    sensed = zip(recorded.ticks(), inprocess.ticks(scenario), strict=True)
    for tick, again in sensed:
        observation = messages.decode_observation(tick.payloads.observations[4])
        beacon = messages.decode_beacon(tick.payloads.beacons[4])
        held = again.state.sensing
        assert held is not None
        assert observation.pose == tuple(held.held.poses[4])
        assert observation.fixed == held.held.ticks[4] <= observation.tick == tick.number
        if kind == "unfiltered":
            assert beacon.pose == observation.pose  # a beacon has the pose that its robot believes
    assert beacon.pose != tuple(again.state.poses[4])


def test_a_world_with_noise_can_be_resumed_after_every_tick(tmp_path: Path) -> None:
    scenario = load("measured.toml", run__duration=0.4, **KINDS["together"])
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    checkpoints, team = CheckpointWriter(first, 1e9, "x", "main"), Team(scenario)
    run = Run(scenario, note=checkpoints.note)
    checkpoints.begin(run)
    for tick in range(scenario.ticks):
        if tick % 7 == 5:
            checkpoints.save(run, {}, 0.1, at_once=True)
        team.step(run)
        shutil.rmtree(second, ignore_errors=True)
        shutil.copytree(first, second)
        other, kept, _ = resume.run(second, resume.load(second), None, 1e9)
        kept.close(other)
        assert other.state.poses.tobytes() == run.state.poses.tobytes()
        last = [messages.decode_observation(payload) for payload in other.farewells()]
        fixes = truth.observe(run.state).poses
        assert [message.pose for message in last] == [tuple(fix) for fix in fixes.tolist()]
        assert not (fixes == run.state.poses).any()  # a farewell does not tell the truth
        assert not bits.differences(other.state.sensing, run.state.sensing)
        assert not bits.differences(other.state.actual, run.state.actual)
    checkpoints.close(run)
