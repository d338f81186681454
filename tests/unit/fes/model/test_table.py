"""The parameters of an extension: only values that TOML and JSON both hold."""

import datetime
import json
import math
import tomllib
from typing import Any

import pytest
import tomli_w
from pydantic import ValidationError

from fes.errors import ScenarioError
from fes.model.table import OwnTable, Table, Use
from world.config import scenario


def test_parameters_are_the_same_after_they_were_written_as_toml_and_as_json() -> None:
    parameters = {
        "gain": 1e300,
        "count": 2**63,
        "name": "é",
        "is_on": True,
        "rows": [[1, 2.5], []],
        "deep": {"a": {}},
    }
    choice = Use.model_validate({"use": "mylab:Law", **parameters})
    assert choice.parameters == parameters
    assert Use.model_validate_json(choice.model_dump_json()) == choice
    assert Use.model_validate(tomllib.loads(tomli_w.dumps(json.loads(choice.model_dump_json())))) == choice


@pytest.mark.parametrize(
    ("parameters", "field"),
    [
        ({"gain": math.inf}, "gain: must be a finite number, a text, true or false, a list or a table, got inf"),
        ({"gain": math.nan}, "gain: must be a finite number, .*, got nan"),
        ({"rows": [[1.0, -math.inf]]}, r"rows\.0\.1: must be .*, got -inf"),
        ({"deep": {"gain": None}}, r"deep\.gain: must be .*, got None"),
        ({"day": datetime.date(2024, 1, 1)}, r"day: must be .*, got datetime\.date\(2024, 1, 1\)"),
    ],
)
@pytest.mark.parametrize(
    ("table", "key"), [("channel", "model"), ("formation", "law"), ("robots", "controller"), ("seeking", None)]
)
def test_a_parameter_that_would_not_last_is_refused_wherever_it_stands(
    parameters: dict[str, Any], field: str, table: str, key: str | None
) -> None:
    choice = {"use": "mylab:Law", **parameters}
    tables: dict[str, Any] = {"schema": 1, "robots": {"count": 2}}
    tables[table] = {**tables.get(table, {}), key: choice} if key else choice
    path = f"{table}.{key}" if key else table
    with pytest.raises(ScenarioError, match=f"^here: {path}: {field}$"):
        scenario.parse(tables, "here")


@pytest.mark.parametrize(
    ("table", "key", "name"),
    [
        ("channel", "model", "logistic"),
        ("formation", "law", "voronoi"),
        ("formation", "rule", "disk"),
        ("robots", "dynamics", "unicycle"),
    ],
)
def test_a_table_without_parameters_is_the_name_alone(table: str, key: str, name: str) -> None:
    def with_choice(choice: Any) -> scenario.Scenario:
        tables: dict[str, Any] = {"schema": 1, "robots": {"count": 2}}
        return scenario.parse({**tables, table: {**tables.get(table, {}), key: choice}}, "here")

    assert with_choice({"use": name}) == with_choice(name)


def test_a_table_of_fes_builds_its_validator_at_the_first_use_and_one_of_an_extension_at_once() -> None:
    class Own(OwnTable):
        gain: float = 1.0

    class Parameters(Table):
        gain: float = 1.0

    assert not Own.__pydantic_complete__
    assert Parameters.__pydantic_complete__
    with pytest.raises(ValidationError, match="Input should be a valid number"):
        Own.model_validate({"gain": "1"})
    assert Own.__pydantic_complete__
