"""The page of a scenario: every table and field, with type, unit, range, default and meaning."""

import json
import re
from typing import Any

from docs.generators.markdown import code, prose, table
from world.config.scenario import Scenario

TITLE = "Scenario"
INTRODUCTION = """A scenario is one TOML file. This page lists every field that it can have. Unknown fields are
errors, and the message names the nearest known field. `--set a.b=c` overrides a field by its dotted path, and `fes
schema` prints the same information as JSON schema.

A range in brackets includes its ends, a range in parentheses excludes them. Rules that involve several fields are
checked when the scenario is loaded; the error states the rule and the offending value."""
UNIT = re.compile(
    r" ?\[((?:1|m|s|rad|dB|ticks|bit|days)"
    r"(?:[/;,^ ](?:1|m|s|Hz|rad|m\^2|frame|world|body|wall|clock|[/;, ])*)*)\]"
)
"""A unit as the docstrings write it, such as [bit/s/Hz] or [m, m, rad; world frame]."""


def page() -> list[str]:
    """The lines of the page, without its title."""
    schema = Scenario.model_json_schema()
    waiting: list[tuple[str, dict[str, Any]]] = [("", schema)]
    lines: list[str] = []
    while waiting:
        path, found = waiting.pop(0)
        inner: list[tuple[str, dict[str, Any]]] = []
        lines += [f"## {f'`{path}`' if path else 'Top level'}", "", prose(found.get("description", "")), ""]
        required = set(found.get("required", ()))
        rows = []
        for name, field in found["properties"].items():
            below, repeated = _table(schema, field)
            if below is not None:
                full = f"{path.strip('[]')}.{name}".strip(".")
                inner.append((f"[[{full}]]" if repeated else f"[{full}]", below))
            default = "required" if name in required else _value(field.get("default"))
            described = " ".join(field.get("description", "").split())
            kind = "tables" if repeated and below else "table" if below else _kind(field)
            meaning = prose(UNIT.sub("", described, count=1))
            rows.append([code(name), kind, unit(described), _range(field), code(default), meaning])
        lines += table(["field", "type", "unit", "range", "default", "meaning"], rows)
        waiting = inner + waiting
    return lines


def unit(description: str) -> str:
    """The unit that a description names first in brackets, or nothing."""
    found = UNIT.search(description)
    return found[1] if found else ""


def _options(field: dict[str, Any]) -> list[dict[str, Any]]:
    return [kind for kind in field.get("anyOf", [field]) if kind.get("type") != "null"]


def _table(schema: dict[str, Any], field: dict[str, Any]) -> tuple[dict[str, Any] | None, bool]:
    """The table that a field holds, if it holds one; True if the field is a list of them."""
    for option in _options(field):
        repeated = option.get("type") == "array"
        inner = option.get("items", {}) if repeated else option
        if name := inner.get("$ref", "").rpartition("/")[2]:
            return schema["$defs"][name], repeated
    return None, False


def _kind(field: dict[str, Any]) -> str:
    return " or ".join(_type(option) for option in _options(field))


def _type(option: dict[str, Any]) -> str:
    if "enum" in option:
        return ", ".join(code(f'"{value}"') for value in option["enum"])
    if option.get("type") == "array":
        parts = option.get("prefixItems")
        if parts:
            return f"list of {len(parts)} {_plural(parts[0])}"
        return f"list of {_plural(option.get('items', {}))}"
    names = {"number": "number", "integer": "integer", "boolean": "boolean", "string": "string", "object": "table"}
    return names.get(option.get("type", ""), "value")


def _plural(option: dict[str, Any]) -> str:
    name = _type(option)
    return name.replace("list", "lists", 1) if name.startswith("list") else f"{name}s"


def _range(field: dict[str, Any]) -> str:
    for option in _options(field):
        low, above = option.get("minimum"), option.get("exclusiveMinimum")
        high, below = option.get("maximum"), option.get("exclusiveMaximum")
        if option.get("type") == "array":
            inner = option.get("items") or (option.get("prefixItems") or [{}])[0]
            ends = _range(inner)
            return f"each {ends.removeprefix('each ')}" if ends else ""
        if {low, above, high, below} == {None}:
            continue
        start = f"[{_number(low)}" if low is not None else f"({_number(above)}" if above is not None else "(-∞"
        end = f"{_number(high)}]" if high is not None else f"{_number(below)})" if below is not None else "∞)"
        return f"{start}, {end}"
    return ""


def _value(default: Any) -> str:
    if default is None:
        return "none"
    if isinstance(default, float):
        return _number(default)
    return "" if isinstance(default, dict) else json.dumps(default)


def _number(value: float) -> str:
    """A number as short as it can be written without a loss."""
    if value == 2**63:
        return "2^63"
    short = f"{value:g}"
    return (
        re.sub(r"e([+-])0*", lambda found: f"e{found[1].strip('+')}", short) if float(short) == value else repr(value)
    )
