"""The table [seeking]: each law has only its own keys, and a broken rule is one line that names the field."""

import math
from typing import Any

import pytest
from pydantic import TypeAdapter

from fes.errors import ScenarioError
from fes.model import seeking
from fes.model.seeking import MeasuredConfig, OracleConfig, SampledConfig, SeekingConfig
from fes.model.table import Use
from tests.support.paths import CONFIGS
from world.config import scenario

TABLE: TypeAdapter[Any] = TypeAdapter(SeekingConfig)

FORMER: dict[str, Any] = {
    "index": "oracle",
    "index_transform": "log",
    "law": "consensus",
    "pooling": "network",
    "reference_separation": 75.0,
    "dither_amplitude": 0.2,
    "dither_frequency": 100.0,
    "index_gain": 40000.0,
    "low_pass_cutoff": 4.0,
    "washout_cutoff": 25.0,
    "consensus_gain": 4.0,
    "sub_step": 0.02,
    "initial_estimate": [50.0, 90.0],
}
"""The table that fes 0.3 wrote for a scenario without [seeking]: every key, with its default."""


def refusal(**table: Any) -> str:
    """The line that rejects a scenario with this table."""
    with pytest.raises(ScenarioError) as caught:
        scenario.parse({"schema": 1, "robots": {"count": 2}, "seeking": table}, "here")
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix("here: ")


@pytest.mark.parametrize(
    ("index", "kind"), [("oracle", OracleConfig), ("measured", MeasuredConfig), ("sampled", SampledConfig)]
)
def test_the_index_chooses_the_table_of_its_law(index: str, kind: type[Any]) -> None:
    chosen = TABLE.validate_python({"index": index, "dither_amplitude": 0.5})
    assert type(chosen) is kind
    assert (chosen.index, chosen.dither_amplitude) == (index, 0.5)
    assert TABLE.validate_python(chosen.model_dump()) == chosen
    assert TABLE.validate_json(TABLE.dump_json(chosen)) == chosen


def test_without_an_index_the_law_is_the_oracles() -> None:
    assert TABLE.validate_python({}) == OracleConfig()
    assert TABLE.validate_python({"law": "paper"}) == OracleConfig(law="paper")


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, OracleConfig()),
        ({"index": "measured"}, MeasuredConfig(index="measured")),
        ({"index": "sampled", "index_transform": "none"}, SampledConfig(index="sampled")),
        ({"index": "measured", "pooling": "none"}, MeasuredConfig(index="measured", pooling="none")),
    ],
)
def test_keys_that_the_law_does_not_use_are_dropped_if_they_have_the_default_of_fes_0_3(
    changes: dict[str, Any], expected: Any
) -> None:
    assert TABLE.validate_python({**FORMER, **changes}) == expected


@pytest.mark.parametrize(
    ("index", "name", "value"),
    [
        ("oracle", "pooling", "none"),
        ("oracle", "reference_separation", 80.0),
        ("sampled", "pooling", "none"),
        ("measured", "law", "paper"),
        ("measured", "index_gain", 44460.0),
        ("measured", "low_pass_cutoff", 5.0),
        ("measured", "washout_cutoff", 26.0),
        ("measured", "sub_step", 0.01),
        ("measured", "index_transform", "none"),
    ],
)
def test_a_key_that_the_law_does_not_use_is_rejected_with_any_other_value(index: str, name: str, value: Any) -> None:
    expected = f"seeking: {name} is not used with index '{index}': leave it out"
    assert refusal(index=index, **{name: value}) == expected


def test_the_defaults_of_fes_0_3_are_those_of_the_laws_today() -> None:
    """Otherwise a table of fes 0.3 would be read as another one."""
    for kind in seeking.BUILT_IN.values():
        for name, field in kind.model_fields.items():
            former = FORMER[name]
            default = tuple(former) if isinstance(former, list) else former
            assert name == "index" or field.default == default or (kind, name) == (SampledConfig, "index_transform")


def test_dropping_keys_changes_neither_the_table_nor_one_of_an_extension() -> None:
    table = {**FORMER, "index": "measured"}
    assert set(seeking.without_unused(table)) == set(MeasuredConfig.model_fields)
    assert table == {**FORMER, "index": "measured"}
    other = {"use": "mylab:Law", "pooling": "none", "law": "paper"}
    assert seeking.without_unused(other) is other


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"dither_amplitude": -1.0}, "seeking.dither_amplitude: must be greater than 0, got -1.0"),
        ({"index": "measured", "pooling": "all"}, "seeking.pooling: must be 'network' or 'none', got 'all'"),
        ({"index": "sampled", "index_transform": "log"}, "seeking.index_transform: must be 'none', got 'log'"),
        ({"index": "measured", "poling": "none"}, "unknown field 'seeking.poling'; did you mean 'seeking.pooling'?"),
        ({"index_gian": 1.0}, "unknown field 'seeking.index_gian'; did you mean 'seeking.index_gain'?"),
        ({"initial_estimate": [50.0, "x"]}, "seeking.initial_estimate.1: must be a valid number, got 'x'"),
        ({"initial_estimate": [90.0, 50.0]}, "seeking: initial_estimate must be [low, high], got [90.0, 50.0]"),
        ({"use": 3}, "seeking.use: must be a valid string, got 3"),
    ],
)
def test_an_error_names_the_field_and_not_the_member_of_the_union(table: dict[str, Any], message: str) -> None:
    assert refusal(**table) == message


@pytest.mark.parametrize("index", ["orcale", 3, None, ["oracle"], "x" * 10_000])
def test_an_unknown_index_is_rejected_with_those_that_exist(index: Any) -> None:
    message = refusal(index=index)
    assert message.startswith("seeking: index must be 'oracle', 'measured' or 'sampled'; `use` names an extension")
    assert len(message) < 250


def test_a_table_with_use_belongs_to_the_extension() -> None:
    chosen = TABLE.validate_python({"use": "mylab:Gradient", "gain": 3.0, "index": "of its own", "deep": {"a": [1]}})
    assert type(chosen) is Use
    assert chosen.use == "mylab:Gradient"
    assert chosen.parameters == {"gain": 3.0, "index": "of its own", "deep": {"a": [1]}}
    assert TABLE.validate_json(TABLE.dump_json(chosen)) == chosen


@pytest.mark.parametrize(
    ("name", "index"),
    [("oracle", "oracle"), ("sampled", "sampled"), ("measured", "measured"), ("measured, none", "measured")],
)
def test_a_law_with_an_index_is_not_an_extension_and_keeps_its_rules(name: str, index: str) -> None:
    expected = f"seeking: use names an extension, and '{name}' is built in: write index = '{index}'"
    assert refusal(use=name, dither_amplitude=0.5) == expected
    assert refusal(use=name) == expected


@pytest.mark.parametrize("name", ["", "x" * 201])
def test_the_name_of_an_extension_has_1_to_200_characters(name: str) -> None:
    assert refusal(use=name).startswith("seeking.use: ")


def test_only_robots_that_drive_to_the_dithered_separations_have_a_physical_period() -> None:
    assert OracleConfig(dither_frequency=2.0).physical_period is None
    for driven in (MeasuredConfig(index="measured", dither_frequency=2.0), SampledConfig(index="sampled")):
        assert driven.physical_period == pytest.approx(2.0 * math.pi / driven.dither_frequency, rel=1e-15)
    assert MeasuredConfig(index="measured", dither_frequency=2.0).physical_period == math.pi


def test_only_the_oracle_knows_the_channel() -> None:
    assert {index: kind.knows_channel for index, kind in seeking.BUILT_IN.items()} == {
        "oracle": True,
        "measured": False,
        "sampled": False,
    }


def test_an_override_of_the_index_drops_the_keys_of_the_other_law_in_the_file_but_none_that_is_set() -> None:
    pair = CONFIGS / "pair.toml"
    measured = scenario.load(pair, {"seeking.index": "measured"}).seeking
    assert isinstance(measured, MeasuredConfig)
    with pytest.raises(ScenarioError, match="seeking: sub_step is not used with index 'measured': leave it out"):
        scenario.load(pair, {"seeking.index": "measured", "seeking.sub_step": 0.01})
