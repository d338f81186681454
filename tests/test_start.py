"""What a team starts from: poses, and what its agents are told."""

import math
from typing import Any

import numpy as np

from fes.arrays import Floats
from fes.config import AgentConfig
from tests.loop import CONFIGS
from world import scenario

PAIR = CONFIGS / "pair.toml"


def test_explicit_poses_are_the_start() -> None:
    start = scenario.initial_poses(scenario.load(PAIR))
    assert start.tolist() == [[0.0, 0.0, 0.5], [100.0, 0.0, 2.0]]


def generated(**robots: Any) -> Floats:
    seed = robots.pop("seed", 1)
    tables = {"schema": 1, "run": {"seed": seed}, "robots": {"count": 10, "spacing": 70.0, **robots}}
    return scenario.initial_poses(scenario.parse(tables, "here"))


def test_a_generated_start_is_a_function_of_its_seed() -> None:
    assert np.array_equal(generated(jitter=5.0), generated(jitter=5.0))
    assert not np.array_equal(generated(jitter=5.0), generated(jitter=5.0, seed=2))


def test_a_generated_robot_starts_where_it_would_in_a_larger_line() -> None:
    few, many = (generated(kind="line", jitter=5.0, count=count) for count in (5, 10))
    assert few[:, :2].tolist() == many[:5, :2].tolist()


def test_a_grid_without_jitter_is_square_and_headings_point_everywhere() -> None:
    start = generated()
    expected = [(70.0 * (k % 4), 70.0 * (k // 4)) for k in range(10)]
    assert [tuple(row) for row in start[:, :2].tolist()] == expected
    headings = sorted(generated(count=1000)[:, 2].tolist())
    assert -math.pi <= headings[0] < -3.0
    assert 3.0 < headings[-1] < math.pi


def test_jitter_moves_a_robot_by_no_more_than_it_says() -> None:
    moved: Floats = generated(count=1000, jitter=5.0)[:, :2] - generated(count=1000)[:, :2]
    assert 4.9 < abs(moved).max() <= 5.0
    # uniform in +-5 m: standard error of the mean 5/sqrt(3 n) = 0.09 m; 4 sigma
    assert abs(moved.mean(axis=0)).max() < 4 * 0.09
    x, y = moved.T
    assert abs(float(np.mean(x * y)) / (25.0 / 3.0)) < 4.0 / math.sqrt(1000)  # x and y are independent


def test_an_agent_is_told_the_channel_for_the_oracle_only() -> None:
    loaded = scenario.load(PAIR)
    assert scenario.agent_config(loaded).channel == loaded.channel.formula
    measured = loaded.model_copy(update={"seeking": loaded.seeking.model_copy(update={"index": "measured"})})
    assert scenario.agent_config(measured).channel is None


def test_an_agents_seed_is_not_the_worlds() -> None:
    told = [scenario.agent_config(scenario.load(PAIR, {"run.seed": seed})).seed for seed in range(20)]
    assert len(set(told)) == 20
    assert not set(told) & set(range(20))


def test_an_agent_is_told_no_position_and_no_duration() -> None:
    assert set(AgentConfig.model_fields) == {
        "dt",
        "seed",
        "objective",
        "seeking",
        "formation",
        "channel",
        "clock",
        "clock_skew",
        "faults",
    }
