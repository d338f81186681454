"""The fields of a scenario: each has a description, a number its unit, and the JSON schema is current."""

import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

from fes.errors import ScenarioError
from fes.model.config import AgentConfig, FaultConfig
from fes.model.table import Table
from fes.settings import schema as settings
from fes.settings import validation
from fes.system import strict_json
from tests.support.paths import CONFIGS
from world.config import scenario as scenarios
from world.config.schema import ScenarioFile

FIELDS = {field.path: field for field in settings.fields(ScenarioFile)}
UNIT_OF_THE_KEY = {"expect[].below", "expect[].above", "expect[].equals"}
"""Numbers whose unit is that of the summary's key."""
SCHEMA = CONFIGS / "scenario.schema.json"
FILES = sorted(CONFIGS.rglob("*.toml"))


def test_every_field_has_a_description() -> None:
    bare = [path for path, field in FIELDS.items() if len(field.description.split()) < 2]
    assert bare == []
    assert all(field.description.endswith(".") for field in FIELDS.values())
    assert [name.replace("[]", "") for name in FIELDS] == validation._fields(ScenarioFile, "")


@pytest.mark.parametrize("model", [AgentConfig, FaultConfig])
def test_every_field_of_an_agents_configuration_has_one_too(model: type[Table]) -> None:
    described = {name for name, field in model.model_fields.items() if field.description}  # such as Clock's own
    assert described | settings.attribute_docstrings(model).keys() == set(model.model_fields)


def test_every_number_has_a_unit_and_no_other_field() -> None:
    for path, field in FIELDS.items():
        assert bool(field.unit) == ("number" in field.type and path not in {*UNIT_OF_THE_KEY, "expect[].equals"}), (
            path
        )
        assert "[" not in field.description, path


def test_a_field_has_type_range_default_and_unit() -> None:
    assert FIELDS["channel.path_loss_exponent"] == settings.SettingsField(
        "channel.path_loss_exponent",
        "number",
        "1",
        "> 0, <= 20",
        3.0,
        False,
        "Path-loss exponent (nu of (3)).",
    )
    assert FIELDS["robots.poses"][1:3] == ("list of lists of 3 numbers", "m, m, rad")
    assert FIELDS["channel.jammers[].radius"].is_required
    assert FIELDS["channel.shadowing"].type == "table"
    assert FIELDS["run.clock"].type == "`lockstep`, `live`"
    assert FIELDS["run.seed"].range == f">= 0, < {2**63}"


def test_the_schema_in_configs_is_current() -> None:
    advice = "fes schema > configs/scenario.schema.json"
    assert strict_json.loads(SCHEMA.read_bytes()) == settings.json_schema(ScenarioFile), advice


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_scenario_names_the_schema_for_editors_and_conforms_to_it(path: Any) -> None:
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert (path.parent / first.removeprefix("#:schema ")).resolve() == SCHEMA
    scenario, model = tomllib.loads(path.read_text(encoding="utf-8")), settings.json_schema(ScenarioFile)
    assert list(broken(scenario, model, model["$defs"], "")) == []


def broken(table: dict[str, Any], model: dict[str, Any], models: dict[str, Any], prefix: str) -> Iterator[str]:
    """The fields of a table that its schema does not have, or requires to be there or to be another text."""
    yield from (prefix + name for name in {*model.get("required", ())} - {*table})
    for name, value in table.items():
        if name not in model["properties"]:
            if not model.get("additionalProperties", False):
                yield prefix + name
            continue
        field = model["properties"][name]
        if value != field.get("const", value) or value not in field.get("enum", [value]):
            yield f"{prefix}{name}={value}"
        kinds = [field, *field.get("anyOf", ()), *field.get("oneOf", ()), field.get("items", {})]
        members = [models[kind["$ref"].rpartition("/")[2]] for kind in kinds if "$ref" in kind]
        for part in value if isinstance(value, list) else [value]:
            if members and isinstance(part, dict):
                yield from min((list(broken(part, inner, models, f"{prefix}{name}.")) for inner in members), key=len)


@pytest.mark.parametrize(
    "seeking",
    [
        {"index": "measured", "sub_step": 0.1},
        {"index_transform": "none", "pooling": "none"},
        {"index": "measured", "pooling": "all"},
        {"index": "sampled", "index_transform": "log"},
    ],
)
def test_the_schema_knows_which_fields_go_with_an_index(seeking: dict[str, Any]) -> None:
    model, tables = settings.json_schema(ScenarioFile), {"schema": 1, "robots": {"count": 2}, "seeking": seeking}
    assert len(list(broken(tables, model, model["$defs"], ""))) == 1
    with pytest.raises(ScenarioError):
        scenarios.parse(tables, "here")


def test_the_fields_of_all_seeking_laws_are_listed_once_with_the_indices_that_have_them() -> None:
    listed = [field.path for field in settings.fields(ScenarioFile) if field.path.startswith("seeking.")]
    assert len(listed) == len(set(listed)) == 14
    assert FIELDS["seeking.index"].type == "`oracle`, `measured`, `sampled`"
    assert FIELDS["seeking.index"].default == "oracle"
    assert FIELDS["seeking.use"].type == "string"
    only = {path: field.description.partition(" Only with index ")[2] for path, field in FIELDS.items()}
    assert {path.partition(".")[2]: text for path, text in only.items() if text} == {
        **dict.fromkeys(["law", "index_gain", "low_pass_cutoff", "washout_cutoff"], "`oracle` or `sampled`."),
        **dict.fromkeys(["sub_step", "index_transform"], "`oracle` or `sampled`."),
        **dict.fromkeys(["pooling", "reference_separation"], "`measured`."),
    }
    assert not FIELDS["seeking.index"].is_required
    assert not FIELDS["seeking.use"].is_required


def test_a_choice_of_an_extension_is_a_name_or_a_table_and_has_a_default() -> None:
    assert FIELDS["formation.rule"].type == "string or table"
    assert FIELDS["formation.rule"].default == "relative_neighborhood"
    assert FIELDS["formation.rule.use"].is_required
