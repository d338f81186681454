"""Overrides of a scenario's fields, for `--set`."""

from collections.abc import Collection, Mapping
from typing import Any

from fes.errors import ScenarioError
from fes.model.seeking import BUILT_IN
from fes.settings import toml
from fes.settings.validation import short
from fes.system import encoding


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


def apply(tables: dict[str, Any], overrides: Mapping[str, Any]) -> None:
    """Set fields in nested tables, by dotted path; raises ScenarioError in one line.

    If they choose another seeking law, the keys of the file that this law does not have are dropped.
    """
    law = _seeking_law(tables)
    for dotted, value in overrides.items():
        override(tables, dotted, value)
    if _seeking_law(tables) != law:
        _drop_former_keys(tables, overrides)


def override(tables: dict[str, Any], dotted: str, value: Any) -> None:
    """Set a field in nested tables, by its dotted path; raises ScenarioError in one line.

    The name of the extension that the field has already keeps its parameters.
    """
    *path, field = dotted.split(".")
    if len(path) > encoding.DEEPEST:
        raise ScenarioError(
            "--set", f"expects a field within at most {encoding.DEEPEST} tables, got '{short(dotted)}'"
        )
    for part in path:
        tables = descend(tables, part)
        if not isinstance(tables, dict):
            raise ScenarioError("--set", f"'{short(dotted)}' goes through '{short(part)}', which is not a table")
    former = tables.get(field)
    if not (isinstance(former, dict) and isinstance(value, str) and former.get("use") == value):
        tables[field] = value


def descend(tables: dict[str, Any], part: str) -> Any:
    """The value of a key, to set a field in it: an absent one, or the name of an extension, becomes a table."""
    value = tables.get(part)
    if value is None or isinstance(value, str):
        tables[part] = value = {} if value is None else {"use": value}
    return value


def value_at(tables: dict[str, Any], dotted: str) -> Any:
    """The value of a field in nested tables, by its dotted path."""
    *path, field = dotted.split(".")
    for part in path:
        tables = descend(tables, part)
    return tables[field]


def _seeking_law(tables: dict[str, Any]) -> Any:
    """The values that choose the seeking law."""
    table = tables.get("seeking")
    if not isinstance(table, dict):
        return None
    return table.get("use"), table.get("index", "oracle")


def _drop_former_keys(tables: dict[str, Any], overridden: Collection[str]) -> None:
    """Drop the file's keys that the seeking law does not have, after overrides chose another law."""
    if "seeking" in overridden:
        return
    table = tables["seeking"]
    if "seeking.index" in overridden and "seeking.use" not in overridden:
        table.pop("use", None)
    kind = BUILT_IN.get(str(table.get("index", "oracle"))) if "use" not in table else None
    known = {"use"} if kind is None else set(kind.model_fields)
    for name in [name for name in table if name not in known and f"seeking.{name}" not in overridden]:
        del table[name]
