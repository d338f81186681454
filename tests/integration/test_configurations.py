"""A team that takes up a configuration has one digest: in one loop, stacked, over Zenoh, and replayed."""

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

CREWS = {"one": [[i] for i in range(11)], "many": [[3, 4, 5], [0, 1, 2, 6, 7, 8, 9, 10]]}
EVENTS = [{"at": 0.0, "kill": [10]}, {"at": 2.4, "kill": [2, 5]}, {"at": 4.2, "restart": [10, 2]}]
"""As in the scenario, but early: two die, one joins, and one of the dead restarts."""


def team(seed: int, **settings: Any) -> Scenario:
    return load("team.toml", run__seed=seed, run__duration=6.6, event=EVENTS, **settings)


@pytest.mark.parametrize(
    ("seed", "crew", "settings"),
    [
        (1, "one", {}),
        (2, "many", {}),
        (3, "one", {"run__clock_skew": 0.3, "channel__bursts": {"bad_share": 0.2, "mean_length": 0.5}}),
        (4, "many", {"formation__configuration": "ring", "formation__marks_per_beacon": 2}),
    ],
)
def test_a_team_has_one_digest_in_one_loop_and_over_zenoh(seed: int, crew: str, settings: dict[str, Any]) -> None:
    scenario = team(seed, **settings)
    summary, server, agents = session.finished(scenario, CREWS[crew])
    assert summary["digest"] == inprocess.run(scenario, "test")["digest"]
    assert not server.drops.counts
    assert not any(any(agent.drops.counts.values()) for agent in agents)


def test_stacked_teams_have_the_summaries_that_they_have_alone() -> None:
    scenarios = [team(seed) for seed in (5, 0)]
    result = [without_wall_clock(summary) for summary in stacked.run(scenarios, "x")]
    assert result == alone(scenarios)


def test_the_log_of_a_team_is_executed_again_by_all_robots_and_by_each_alone(tmp_path: Path) -> None:
    scenario = team(6)
    recordings.record(tmp_path / "loop.mcap", scenario)
    with Recorder(tmp_path / "bus.mcap", scenario, "test", "processes") as recorder:
        summary, *_ = session.finished(scenario, CREWS["one"], recorder)
        recorder.conclude(summary)
    loop, over = (log.load(tmp_path / name) for name in ("loop.mcap", "bus.mcap"))
    assert compare.first_difference(loop, over) is None
    assert replay_command.rerun(over, all_robots=True)["digest"] == summary["digest"]
    assert [replay_command.rerun_robot(over, robot) for robot in (0, 2, 10)] == [330] * 3
