"""The fields of a scenario: each has a description, a number its unit, and the JSON schema is current."""

import tomllib
from typing import Any

import pytest

from fes.model.config import AgentConfig, FaultConfig
from fes.model.table import Table
from fes.system import strict_json
from tests.support.paths import CONFIGS
from world.config import schema, validation
from world.config.scenario import Scenario

FIELDS = {field.path: field for field in schema.fields()}
UNIT_OF_THE_KEY = {"expect[].below", "expect[].above", "expect[].equals"}
"""Numbers whose unit is that of the summary's key."""
SCHEMA = CONFIGS / "scenario.schema.json"
FILES = sorted(CONFIGS.rglob("*.toml"))


def test_every_field_has_a_description() -> None:
    bare = [path for path, field in FIELDS.items() if len(field.description.split()) < 2]
    assert bare == []
    assert all(field.description.endswith(".") for field in FIELDS.values())
    assert [name.replace("[]", "") for name in FIELDS] == validation._fields(Scenario, "")


@pytest.mark.parametrize("model", [AgentConfig, FaultConfig])
def test_every_field_of_an_agents_configuration_has_one_too(model: type[Table]) -> None:
    described = {name for name, field in model.model_fields.items() if field.description}  # such as Clock's own
    assert described | schema.attribute_docstrings(model).keys() == set(model.model_fields)


def test_every_number_has_a_unit_and_no_other_field() -> None:
    for path, field in FIELDS.items():
        assert bool(field.unit) == ("number" in field.type and path not in {*UNIT_OF_THE_KEY, "expect[].equals"}), (
            path
        )
        assert "[" not in field.description, path


def test_a_field_has_type_range_default_and_unit() -> None:
    assert FIELDS["channel.path_loss_exponent"] == schema.ScenarioField(
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
    assert strict_json.loads(SCHEMA.read_bytes()) == schema.json_schema(), advice


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_scenario_names_the_schema_for_editors_and_conforms_to_it(path: Any) -> None:
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert (path.parent / first.removeprefix("#:schema ")).resolve() == SCHEMA
    conforms(tomllib.loads(path.read_text(encoding="utf-8")), schema.json_schema(), schema.json_schema()["$defs"])


def conforms(table: dict[str, Any], model: dict[str, Any], models: dict[str, Any]) -> None:
    """Assert that a table has only fields of its schema, and all that are required."""
    assert set(model.get("required", ())) <= table.keys() <= model["properties"].keys()
    for name, value in table.items():
        field = model["properties"][name]
        kinds = [field, *field.get("anyOf", ()), field.get("items", {})]
        for inner in (models[kind["$ref"].rpartition("/")[2]] for kind in kinds if "$ref" in kind):
            for part in value if isinstance(value, list) else [value]:
                conforms(part, inner, models)
