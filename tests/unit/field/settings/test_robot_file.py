"""robot.toml: its fields, its rules, and what becomes of it."""

from pathlib import Path
from typing import Any

import pytest

from fes.errors import FesError, ScenarioError
from fes.model.seeking import MeasuredConfig
from fes.settings.schema import fields
from fes.transport.endpoints import DEFAULT_ENDPOINT
from field.settings import robot_file
from field.settings.for_gate import gate_settings
from field.settings.robot_file import RobotFile
from tests.support.paths import ROOT
from world.config import builtin
from world.config.scenario import load
from world.tabletop.flags import RADIO

EXAMPLE = ROOT / "deploy" / "robots" / "robot.toml"


def parsed(**tables: Any) -> RobotFile:
    return robot_file.parse({"schema": 1, **tables}, "robot.toml")


def test_every_field_has_a_description_and_every_number_a_unit() -> None:
    described = list(fields(RobotFile))
    assert [field.path for field in described if len(field.description.split()) < 2] == []
    assert [field.path for field in described if bool(field.unit) != ("number" in field.type)] == []


def test_the_example_is_valid_and_names_no_field_twice() -> None:
    file = robot_file.load(EXAMPLE, 3)
    assert file.id == 3
    settings = gate_settings(file, 3)
    assert settings.body.command.name == "robot3/cmd_vel"
    assert settings.body.pose.name == "robot3/pose"
    assert settings.limits.linear == file.formation.linear_limit == 2.0


def test_the_example_of_the_table_fits_the_scenario_and_the_defaults_of_fes_tabletop() -> None:
    file = robot_file.load(EXAMPLE.with_name("table.toml"), 0)
    scenario = load(builtin.resolve(Path("tabletop")))
    assert scenario.tabletop is not None
    assert file.formation.linear_limit is not None
    assert isinstance(file.seeking, MeasuredConfig)
    assert isinstance(scenario.seeking, MeasuredConfig)
    assert file.seeking.initial_estimate == scenario.seeking.initial_estimate
    assert file.body.scale == scenario.tabletop.scale
    assert file.limits.linear == scenario.tabletop.linear_limit == file.formation.linear_limit / file.body.scale
    assert file.radio.relay == RADIO
    assert file.body.endpoint == file.team.endpoint == DEFAULT_ENDPOINT


def test_a_robot_is_not_told_its_channel() -> None:
    with pytest.raises(ScenarioError, match="a law that is told the channel cannot run on a real robot"):
        parsed(seeking={"index": "oracle"})
    assert parsed().agent_config.channel is None


def test_an_unknown_field_names_the_nearest_known_one() -> None:
    with pytest.raises(ScenarioError, match=r"unknown field 'body.endpiont'; did you mean 'body.endpoint'"):
        parsed(body={"endpiont": "tcp/127.0.0.1:7447"})


def test_a_run_that_cannot_be_part_of_a_key_is_refused() -> None:
    with pytest.raises(ScenarioError, match="a run's name is 1 to 64"):
        parsed(run="a/b")


def test_a_fence_has_an_area_and_reaches_the_gate_at_full_size() -> None:
    with pytest.raises(ScenarioError, match="at least 3 corners, got 2"):
        parsed(limits={"fence": [[0.0, 0.0], [1.0, 0.0]]})
    file = parsed(body={"scale": 100.0}, limits={"fence": [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]})
    assert gate_settings(file, 0).fence == ((0.0, 0.0), (100.0, 0.0), (100.0, 200.0))


def test_a_driver_on_another_machine_is_refused_unless_it_is_allowed() -> None:
    file = parsed(body={"endpoint": "tcp/10.0.0.3:7447"})
    with pytest.raises(FesError, match=r"expects body\.endpoint on this machine"):
        gate_settings(file, 0)
    assert gate_settings(file, 0, remote=True).body.remote


def test_a_key_file_is_read_and_a_short_one_refused(tmp_path: Path) -> None:
    (tmp_path / "team.key").write_text("0123456789abcdef\n")
    file = parsed(radio={"key_file": "team.key"})
    assert file.radio.settings(tmp_path).key == b"0123456789abcdef"
    (tmp_path / "team.key").write_text("short")
    with pytest.raises(FesError, match=r"16 to 1024 bytes: .*has 5"):
        file.radio.settings(tmp_path)
    with pytest.raises(FesError, match="cannot read"):
        parsed(radio={"key_file": "absent"}).radio.settings(tmp_path)


def test_a_file_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="cannot be read"):
        robot_file.load(tmp_path / "absent.toml")
