"""The table [tabletop]: defaults, rules, and the scenario that ships with it."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fes.errors import ScenarioError
from tests.support import loop
from tests.support.paths import CONFIGS
from world.config import scenario
from world.config.hardware.tabletop import TabletopConfig


def test_the_shipped_scenario_has_the_default_table_and_the_start_of_measured() -> None:
    tabletop, measured = loop.load("tabletop.toml"), loop.load("measured.toml")
    assert tabletop.tabletop == TabletopConfig()
    assert tabletop.robots == measured.robots
    assert tabletop.channel == measured.channel
    assert measured.tabletop is None


def test_the_limits_of_the_law_are_those_of_the_bodies_at_full_size() -> None:
    shipped = loop.load("tabletop.toml")
    table = shipped.tabletop
    assert table is not None
    assert shipped.formation.linear_limit == pytest.approx(table.scale * table.linear_limit)
    assert shipped.formation.angular_limit == table.angular_limit


@pytest.mark.parametrize(("rate", "step", "steps"), [(50.0, 0.005, 4), (200.0, 0.005, 1), (1.0, 0.002, 500)])
def test_a_pose_is_published_after_a_whole_number_of_steps(rate: float, step: float, steps: int) -> None:
    assert TabletopConfig(pose_rate=rate, physics_step=step).steps_per_pose == steps


@given(st.floats(2.0, 50.0), st.sampled_from([0.0005, 0.001, 0.002, 0.003, 0.005, 0.02]))
@settings(max_examples=50, deadline=None)
def test_a_driver_takes_its_commands_after_10_ms_at_the_latest_or_after_each_step(rate: float, step: float) -> None:
    config = TabletopConfig(pose_rate=rate, physics_step=step)
    assert config.steps_per_pose % config.steps_per_cycle == 0
    assert config.steps_per_cycle == 1 or config.steps_per_cycle * step <= 0.010001
    assert TabletopConfig().steps_per_cycle == 2


@pytest.mark.parametrize(
    ("changes", "rule"),
    [
        ({"pose_rate": 201.0}, "pose_rate must be at most 1 / physics_step, got 201"),
        ({"pose_rate": 0.1}, r"1 / \(pose_rate x physics_step\) must be at most 1000, got 2000"),
        ({"body_radius": 0.05}, "body_radius must exceed wheel_radius and be at least half the track, got 0.05"),
        ({"pose_topic": "/odom"}, "a topic contains {robot} once, .* got '/odom'"),
        ({"command_topic": "/robot{robot}/*"}, r"a topic contains {robot} once, .* got '/robot{robot}/\*'"),
        ({"command_type": "Bool"}, "command_type"),
        ({"wheels": 3}, "wheels"),
    ],
)
def test_an_impossible_table_is_an_error_in_one_line(changes: dict[str, Any], rule: str) -> None:
    overrides = {f"tabletop.{name}": value for name, value in changes.items()}
    with pytest.raises(ScenarioError, match=rule) as caught:
        scenario.load(CONFIGS / "tabletop.toml", overrides)
    assert "\n" not in str(caught.value)


def test_each_robot_has_topics_of_its_own() -> None:
    config = TabletopConfig()
    assert config.pose_topic_of(3) == "/robot3/odom"
    assert config.command_topic_of(11) == "/robot11/cmd_vel"
