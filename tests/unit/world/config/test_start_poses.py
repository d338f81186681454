"""Starts of a team: poses, and the settings that agents receive."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from console.backends import inprocess
from fes.arrays.types import Floats
from fes.errors import ScenarioError
from fes.model.config import AgentConfig
from tests.support.paths import CONFIGS
from world.config import scenario

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


def test_jitter_moves_a_robot_by_its_value_at_most() -> None:
    moved: Floats = generated(count=1000, jitter=5.0)[:, :2] - generated(count=1000)[:, :2]
    assert 4.9 < abs(moved).max() <= 5.0
    # uniform in +-5 m: standard error of the mean 5/sqrt(3 n) = 0.09 m; 4 sigma
    assert abs(moved.mean(axis=0)).max() < 4 * 0.09
    x, y = moved.T
    assert abs(float(np.mean(x * y)) / (25.0 / 3.0)) < 4.0 / math.sqrt(1000)  # x and y are independent


def test_an_agent_receives_the_channel_for_the_oracle_only() -> None:
    loaded = scenario.load(PAIR)
    assert scenario.agent_config(loaded).channel == loaded.channel.formula
    for index in ("measured", "sampled"):
        blind = scenario.load(PAIR.with_name("measured.toml"), {"seeking.index": index})
        assert scenario.agent_config(blind).channel is None


def test_an_agents_seed_is_not_the_worlds() -> None:
    config = [scenario.agent_config(scenario.load(PAIR, {"run.seed": seed})).seed for seed in range(20)]
    assert len(set(config)) == 20
    assert not set(config) & set(range(20))


def test_an_agent_receives_no_position_and_no_duration() -> None:
    assert set(AgentConfig.model_fields) == {
        "dt",
        "seed",
        "objective",
        "seeking",
        "formation",
        "controller",
        "channel",
        "clock",
        "clock_skew",
        "faults",
        "sensors",
        "localization",
    }


EXTENTS = st.floats(0.0, 20.0).map(lambda power: 10.0**power) | st.sampled_from([5e-324, 1e300, 1.7e308])


@given(
    kind=st.sampled_from(["grid", "line"]),
    count=st.sampled_from([1, 2, 9, 100]),
    spacing=EXTENTS,
    jitter=EXTENTS | st.just(0.0),
)
def test_a_generated_start_is_rejected_or_is_where_floats_resolve_a_millimeter(
    kind: str, count: int, spacing: float, jitter: float
) -> None:
    fields = {"kind": kind, "count": count, "spacing": spacing, "jitter": jitter}
    columns = count - 1 if kind == "line" else math.ceil(math.sqrt(count)) - 1
    extent = spacing * columns + jitter
    if extent > 1e12:
        with pytest.raises(ScenarioError, match=r"robots: spacing and jitter must keep all robots within 1e\+12 m"):
            generated(**fields)
        return
    start = generated(**fields)
    assert np.isfinite(start).all()
    assert np.spacing(np.abs(start[:, :2])).max() < 1e-3


@pytest.mark.parametrize(
    ("pose", "rule"),
    [
        ([1e15, 0.0, 0.0], "poses must be finite and within 1e+12 m of the origin along x and y, got 1e+15"),
        ([0.0, -1e308, 0.0], "poses must be finite and within 1e+12 m of the origin along x and y, got -1e+308"),
        ([0.0, math.inf, 0.0], "poses must be finite and within 1e+12 m of the origin along x and y, got inf"),
        ([0.0, 0.0, 1e9], "poses must have finite headings within 1e+06 rad, got 1e+09"),
        ([0.0, 0.0, math.nan], "poses must have finite headings within 1e+06 rad, got nan"),
    ],
)
def test_a_pose_that_floats_do_not_resolve_is_rejected_in_one_line(pose: list[float], rule: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        scenario.load(PAIR, {"robots.poses": [[0.0, 0.0, 0.0], pose]})
    assert str(refused.value) == f"{PAIR}: robots: {rule}"


def test_robots_ten_to_the_twelve_meters_away_find_the_same_separation() -> None:
    """The spacing of floats there is 0.12 mm."""
    start = [[1e12, 1e12, 0.5], [1e12 - 100.0, 1e12, 0.5]]
    summary = inprocess.run(scenario.load(PAIR, {"robots.poses": start, "run.duration": 20.0}), "far")
    assert summary["separation_error_max"] < 0.02
