"""Overrides of a scenario's fields, for `--set`."""

from typing import Any

from fes.errors import ScenarioError
from fes.system import encoding
from world.config import toml
from world.config.validation import short


def parse_override(text: str) -> tuple[str, Any]:
    """The path and the TOML value of a `--set` argument `a.b=value`; bare words are strings.

    Raises ScenarioError.

    >>> parse_override("run.seed=3"), parse_override("formation.rule=disk")
    (('run.seed', 3), ('formation.rule', 'disk'))
    """
    dotted, equals, raw = encoding.argument(text).partition("=")
    if not equals or not dotted.strip():
        raise ScenarioError("--set", f"expects table.field=value, got '{short(text)}'")
    try:
        parsed = toml.parse(f"value = {raw}")
    except toml.Malformed:
        parsed = {"value": raw}
    except ValueError as error:
        raise ScenarioError("--set", f"{short(dotted.strip())} {error}") from None
    if parsed.keys() != {"value"}:
        raise ScenarioError("--set", f"expects one value, got '{short(raw)}'")
    return dotted.strip(), parsed["value"]


def override(tables: dict[str, Any], dotted: str, value: Any) -> None:
    """Set a field in nested tables, by its dotted path; raises ScenarioError in one line."""
    *path, field = dotted.split(".")
    if len(path) > encoding.DEEPEST:
        raise ScenarioError(
            "--set", f"expects a field within at most {encoding.DEEPEST} tables, got '{short(dotted)}'"
        )
    for part in path:
        tables = tables.setdefault(part, {})
        if not isinstance(tables, dict):
            raise ScenarioError("--set", f"'{short(dotted)}' goes through '{short(part)}', which is not a table")
    tables[field] = value
