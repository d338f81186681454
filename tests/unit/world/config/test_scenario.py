"""Scenarios: valid ones load, and each error is one line."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fes.errors import ScenarioError
from fes.model.seeking import OracleConfig
from tests.support.paths import CONFIGS
from world.config import scenario

PAIR = CONFIGS / "pair.toml"


def minimal(**tables: Any) -> dict[str, Any]:
    return {"schema": 1, "robots": {"poses": [[0.0, 0.0, 0.0]]}, **tables}


def refusal(tables: dict[str, Any]) -> str:
    with pytest.raises(ScenarioError) as caught:
        scenario.parse(tables, "here")
    return str(caught.value)


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.toml")), ids=lambda path: str(path.stem))
def test_every_shipped_scenario_loads_and_starts_a_team(path: Path) -> None:
    loaded = scenario.load(path)
    assert loaded.ticks * loaded.run.dt == pytest.approx(loaded.run.duration)
    start = scenario.initial_poses(loaded)
    assert len(start) == loaded.robots.number >= 2
    assert np.isfinite(start).all()


def test_the_papers_scenario_holds_the_numbers_of_its_section_5() -> None:
    paper = scenario.load(CONFIGS / "paper.toml")
    assert paper.robots.number == 10
    assert paper.robots.poses is not None
    assert paper.robots.poses[6] == (225.0, 0.0, 1.05)
    seeking = paper.seeking
    assert isinstance(seeking, OracleConfig)
    printed = (
        seeking.dither_amplitude,
        seeking.dither_frequency,
        seeking.low_pass_cutoff,
        seeking.washout_cutoff,
    )
    assert printed == (0.2, 100.0, 4.0, 25.0)
    assert seeking.consensus_gain == seeking.low_pass_cutoff**2 / 4.0
    assert (paper.formation.linear_gain, paper.formation.angular_gain) == (1.0, 10.0)
    assert paper.ticks == 3000


@pytest.mark.parametrize(
    ("tables", "unknown", "nearest"),
    [
        (minimal(seeking={"index_gian": 1.0}), "seeking.index_gian", "seeking.index_gain"),
        (minimal(run={"sed": 1}), "run.sed", "run.seed"),
        (minimal(chanel={}), "chanel", "channel"),
        (minimal(formation={"angular_gan": 2.0}), "formation.angular_gan", "formation.angular_gain"),
    ],
)
def test_an_unknown_field_names_the_nearest_known_one(tables: dict[str, Any], unknown: str, nearest: str) -> None:
    assert refusal(tables) == f"here: unknown field '{unknown}'; did you mean '{nearest}'?"


def test_a_field_without_a_similar_one_is_just_unknown() -> None:
    assert refusal(minimal(qqq=1)) == "here: unknown field 'qqq'; fes schema lists the fields"


@pytest.mark.parametrize(
    ("wrong", "meant"),
    [
        ({"channel": {"snr": 3.0}}, "channel.reference_snr"),
        ({"channel": {"maximum_separation": 3.0}}, "objective.maximum_separation"),
        ({"snr": 3.0}, "channel.reference_snr"),
        ({"chanel": {}}, "channel"),
        ({"run": {"sed": 1}}, "run.seed"),
        ({"event": [{"at": 1.0, "transmiter": {}}]}, "event.transmitter"),
    ],
)
def test_an_unknown_field_is_compared_within_its_table_and_then_by_name(wrong: dict[str, Any], meant: str) -> None:
    assert refusal(minimal(**wrong)).endswith(f"; did you mean '{meant}'?")


@pytest.mark.parametrize(
    ("tables", "field", "value"),
    [
        (minimal(run={"dt": "fast"}), "run.dt", "'fast'"),
        (minimal(run={"seed": 1.5}), "run.seed", "1.5"),
        (minimal(run={"seed": True}), "run.seed", "True"),
        (minimal(run={"seed": -1}), "run.seed", "-1"),
        (minimal(run={"dt": 0.0}), "run.dt", "0.0"),
        (minimal(channel={"communication_range": -150.0}), "channel.communication_range", "-150.0"),
        (minimal(channel={"reference_snr": math.inf}), "channel.reference_snr", "inf"),
        (minimal(channel={"reference_snr": math.nan}), "channel.reference_snr", "nan"),
        (minimal(channel={"model": "rician"}), "channel.model", "'rician'"),
        (minimal(formation={"rule": "nearest"}), "formation.rule", "'nearest'"),
        (minimal(seeking={"initial_estimate": [90.0, 50.0]}), "initial_estimate", "[90.0, 50.0]"),
        (minimal(seeking={"sub_step": 0.05}), "sub_step", "got 5"),
        (minimal(run=3), "run", "3"),
        ({"schema": 2, "robots": {"count": 3}}, "schema", "2"),
        ({"schema": 1, "robots": {"count": 0}}, "robots.count", "0"),
        ({"schema": 1, "robots": {"poses": [[0.0, 0.0, math.nan]]}}, "robots", "finite"),
        ({"schema": 1, "robots": {"poses": [[0.0, "a", 0.0]]}}, "robots.poses.0.1", "'a'"),
    ],
)
def test_a_broken_rule_is_reported_in_one_line_with_field_and_value(
    tables: dict[str, Any], field: str, value: str
) -> None:
    message = refusal(tables)
    assert message.startswith("here: ")
    assert "\n" not in message
    assert field in message
    assert value in message


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"schema": 1}, "here: robots: is required"),
        ({"robots": {"count": 2}}, "here: schema: is required"),
        ({"schema": 1, "robots": {}}, "here: robots: give either poses or count"),
        (
            {"schema": 1, "robots": {"count": 1, "poses": [[0.0, 0.0, 0.0]]}},
            "here: robots: give either poses or count",
        ),
        ({"schema": 1, "robots": {"poses": []}}, "here: robots: poses must list 1 to 100000 robots"),
    ],
)
def test_a_missing_or_contradictory_field_is_reported_in_one_line(tables: dict[str, Any], message: str) -> None:
    assert refusal(tables) == message


def test_an_absent_file_is_rejected_by_name(tmp_path: Path) -> None:
    path = tmp_path / "absent.toml"
    with pytest.raises(ScenarioError) as caught:
        scenario.load(path)
    assert str(caught.value) == f"{path}: cannot be read: No such file or directory"


@pytest.mark.parametrize("content", [b"schema = = 1", b"schema = 1\nschema = 2"])
def test_a_file_that_is_not_toml_is_rejected_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "broken.toml"
    path.write_bytes(content)
    with pytest.raises(ScenarioError, match="is not valid TOML") as caught:
        scenario.load(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("text", "path", "value"),
    [
        ("run.seed=3", "run.seed", 3),
        ("run.dt = 0.05", "run.dt", 0.05),
        ("formation.rule=disk", "formation.rule", "disk"),
        ('formation.rule="disk"', "formation.rule", "disk"),
        ("seeking.initial_estimate=[60.0, 80.0]", "seeking.initial_estimate", [60.0, 80.0]),
    ],
)
def test_an_override_is_a_path_and_a_toml_value(text: str, path: str, value: Any) -> None:
    assert scenario.parse_override(text) == (path, value)


@pytest.mark.parametrize("text", ["run.seed", "=3", ""])
def test_an_override_without_path_or_value_is_rejected(text: str) -> None:
    with pytest.raises(ScenarioError, match=r"--set: expects table\.field=value"):
        scenario.parse_override(text)


def test_overrides_change_their_fields_and_no_other() -> None:
    plain = scenario.load(PAIR)
    changed = scenario.load(PAIR, {"run.seed": 9, "formation.linear_limit": 2.5})
    assert (changed.run.seed, changed.formation.linear_limit) == (9, 2.5)
    restored = changed.model_copy(update={"run": plain.run, "formation": plain.formation})
    assert restored == plain


def test_an_override_obeys_the_rules_of_its_field() -> None:
    with pytest.raises(ScenarioError, match=r"unknown field 'run\.sede'; did you mean 'run\.seed'\?"):
        scenario.load(PAIR, {"run.sede": 9})
    with pytest.raises(ScenarioError, match=r"goes through 'dt', which is not a table"):
        scenario.load(PAIR, {"run.dt.x": 9})


LAW = {"use": "voronoi", "gain": 0.5}


@pytest.mark.parametrize(
    "overrides",
    [
        {"formation.law": LAW},
        {"formation.law.use": "voronoi", "formation.law.gain": 0.5},
        {"formation.law": "voronoi", "formation.law.gain": 0.5},
    ],
)
def test_an_override_replaces_the_name_of_an_extension_by_its_table(overrides: dict[str, Any]) -> None:
    whole = scenario.parse(minimal(formation={"law": LAW}), "here")
    for law in ({}, {"law": "paper"}, {"law": "voronoi"}):
        plain = scenario.parse(minimal(formation=law), "here")
        assert scenario.with_overrides(plain, overrides) == whole


def test_an_override_sets_a_field_of_a_table_that_a_loaded_scenario_does_not_have() -> None:
    plain = scenario.load(PAIR)
    expected = scenario.load(PAIR, {"channel.shadowing": {"deviation": 3.0}})
    assert scenario.with_overrides(plain, {"channel.shadowing.deviation": 3.0}) == expected


def test_an_override_with_the_name_of_the_same_extension_keeps_its_parameters() -> None:
    tuned = scenario.parse(minimal(formation={"law": LAW}), "here")
    assert scenario.with_overrides(tuned, {"formation.law": "voronoi"}) == tuned
    assert scenario.with_overrides(tuned, {"formation.law": "paper"}).formation.law == "paper"


@pytest.mark.parametrize(
    ("sensing", "rule"),
    [
        ({"pose_latency": 0.03}, "sensing.pose_latency must be a whole number of ticks, at most 1000, got 1.5"),
        ({"pose_rate": 60.0}, "sensing.pose_rate must be at most 50, one fix per tick, got 60"),
        ({"pose_noise": -1.0}, "sensing.pose_noise"),
        ({"pose_noise": math.nan}, "sensing.pose_noise"),
        ({"pose_drift_time": 0.0}, "sensing.pose_drift_time"),
    ],
)
def test_a_sensor_that_does_not_fit_into_ticks_is_rejected_in_one_line(sensing: dict[str, Any], rule: str) -> None:
    assert rule in refusal(minimal(sensing=sensing))


def test_robots_are_told_the_data_sheet_and_neither_drift_nor_slip_nor_rate() -> None:
    sensing = {"pose_noise": 1.0, "heading_noise": 0.1, "pose_drift": 2.0, "pose_rate": 5.0, "pose_latency": 0.1}
    robots = {"poses": [[0.0, 0.0, 0.0]], "actuator_lag": 0.2, "slip": 0.05}
    told = scenario.agent_config(scenario.parse(minimal(sensing=sensing, robots=robots), "here")).model_dump()
    assert told["sensors"] == {"pose_noise": 1.0, "heading_noise": 0.1, "actuator_lag": 0.2}
    assert told["localization"] == {"filter": "dead_reckoning"}
    hidden = {"pose_drift", "pose_rate", "pose_latency", "pose_drift_time", "slip"}
    assert not hidden & set(told) | hidden & set(told["sensors"])
