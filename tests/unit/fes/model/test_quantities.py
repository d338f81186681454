"""The table of quantities, against the summaries of real runs and against the report."""

from dataclasses import fields
from functools import cache
from typing import Any

import pytest

from console.backends import inprocess
from fes.extension import registry
from fes.model import quantities
from fes.model.quantities import FLAG, NUMBER, OPTIONAL, SUMMARY, TEXT, VERDICTS, Quantity, Shape
from fes.protocol.report import Report
from fes.settings.schema import attribute_docstrings
from tests.support.loop import load
from world.metrics import deadlines

MEASURED = {"run__duration": 1.0, "seeking__dither_frequency": 25.0}
SCENARIOS: dict[str, dict[str, Any]] = {
    "paper.toml": {"run__duration": 1.0},
    "pair.toml": {"run__duration": 0.1, "channel__communication_range": 10.0},
    "measured.toml": MEASURED,
    "faults/death.toml": {"run__duration": 1.0, "metric": [{"use": "tests.support.example_metric:Count"}]},
    "neighborhood.toml": {"run__duration": 1.0, "objective__team_index": True},
    "measured-jump.toml": {**MEASURED, "event": [{"at": 0.5, "set": {"channel.reference_snr": 5e6}}]},
}
KINDS = {NUMBER: (int, float), FLAG: (bool,), TEXT: (str,), "any of these": (int, float, bool, str)}


@cache
def summary(name: str) -> dict[str, Any]:
    registry.use("tests.support.example_metric")
    expected = [{"of": "ticks", "above": 1.0}, {"of": "digest", "equals": "x"}]
    return inprocess.run(load(name, **SCENARIOS[name], expect=expected), name)


def live(summary: dict[str, Any]) -> dict[str, Any]:
    """The summary with the deadlines of a live clock, which no in-process run has."""
    return {**summary, "deadlines": deadlines.no_deadlines(summary["robots"]).table()}


def keys(name: str) -> list[str]:
    """The keys of the summary of a scenario, in order."""
    has_team = "objective__team_index" in SCENARIOS[name]
    return [key for key in quantities.shape() if has_team or key not in OPTIONAL]


def is_of(shape: Shape, value: Any) -> bool:
    """True if a part of a summary has this shape."""
    if value is None:
        return True
    if isinstance(shape, dict) and list(shape) == ["*"]:
        return isinstance(value, dict) and all(is_of(shape["*"], part) for part in value.values())
    if isinstance(shape, dict):
        return list(shape) == list(value) and all(is_of(shape[key], value[key]) for key in shape)
    if isinstance(shape, list):
        return all(is_of(shape[0], entry) for entry in value)
    if isinstance(shape, tuple):
        return all(is_of(*pair) for pair in zip(shape, value, strict=True))
    return type(value) in KINDS[shape]


def values(summary: Any, name: str = "") -> dict[str, list[Any]]:
    """Name of a quantity -> its values in a summary."""
    if isinstance(summary, dict) and name == "metrics":
        parts = [values(part, "metrics.*.*") for table in summary.values() for part in table.values()]
    elif isinstance(summary, dict):
        parts = [values(part, f"{name}.{key}" if name else key) for key, part in summary.items()]
    elif isinstance(summary, list) and name in ("edges[]", "radio[]"):
        parts = [values(part, f"{name}.{column}") for column, part in enumerate(summary)]
    elif isinstance(summary, list):
        parts = [values(part, f"{name}[]") for part in summary]
    else:
        return {name: [summary]}
    joined: dict[str, list[Any]] = {}
    for part in parts:
        for key, result in part.items():
            joined.setdefault(key, []).extend(result)
    return joined


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_summary_has_the_keys_of_the_table_in_its_order_and_no_others(name: str) -> None:
    wanted = quantities.shape()
    assert is_of({key: wanted[key] for key in keys(name)}, live(summary(name)))
    assert list(summary(name)) == keys(name)
    assert values(live(summary(name))).keys() <= {quantity.name for quantity in SUMMARY} | {"edges", "radio"}


def test_every_quantity_occurs_in_some_summary() -> None:
    occurring = set[str]().union(*(values(live(summary(name))) for name in SCENARIOS))
    assert occurring >= {quantity.name for quantity in SUMMARY}


def test_only_quantities_that_state_when_they_are_null_are_null() -> None:
    conditions = {quantity.name: quantity.null for quantity in SUMMARY}
    null = {key for name in SCENARIOS for key, result in values(summary(name)).items() if None in result}
    assert "disagreement" in null
    assert {key for key in null - {"deadlines"} if not conditions[key]} == set()


def test_each_quantity_has_a_name_of_its_own_a_sentence_and_a_unit_if_it_measures() -> None:
    assert len({quantity.name for quantity in SUMMARY}) == len(SUMMARY)
    labels = {"seed", "edges[].0", "edges[].1", "radio[].0", "radio[].1"}
    for quantity in SUMMARY:
        assert quantity.description.endswith("."), quantity
        assert len(quantity.description.split()) > 1, quantity
        assert bool(quantity.unit) == (quantity.kind == NUMBER and quantity.name not in labels), quantity
        assert not quantity.null.endswith("."), quantity


def test_a_summary_whose_keys_are_not_the_tables_is_an_error() -> None:
    complete = {**summary("pair.toml")}
    assert quantities.ordered(dict(reversed(complete.items()))) == complete
    lacking = {key: complete[key] for key in complete if key != VERDICTS}
    for wrong in ({**complete, "new": 1}, lacking, {**complete, "team_index": 0.5}):
        with pytest.raises(KeyError, match="only in the summary, or only in its table: "):
            quantities.ordered(wrong)


def test_a_number_that_summary_and_report_share_has_one_unit() -> None:
    units = {quantity.name: quantity.unit for quantity in SUMMARY}
    texts = attribute_docstrings(Report)
    shared = [field.name for field in fields(Report) if units.get(field.name) in ("m", "s", "1/s")]
    assert len(shared) >= 6
    assert [name for name in shared if f"[{units[name]}]" not in texts[name]] == []


def test_the_table_describes_each_value_with_its_own_shape() -> None:
    assert quantities.shape([Quantity("a[].b[]", "m", "")]) == {"a": [{"b": [NUMBER]}]}
