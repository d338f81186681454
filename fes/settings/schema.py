"""The fields of a file of settings: type, range, default, unit and description, as a list and as a JSON schema.

Descriptions are the docstrings of the fields. They are read from the source on demand, so that no agent, of which
hundreds may start at once, spends time on them.
"""

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

from fes.model.table import Table
from fes.settings.validation import tables_within

_UNITS = r"1|m|s|rad|kg|N m|dB|m/s|rad/s|m/s\^2|rad/s\^2|1/s|rad/s/m|bit/s/Hz|ticks"
_UNIT = re.compile(rf" ?\[((?:{_UNITS})(?:, (?:{_UNITS}))*)(?:; ([^\]]+))?\]")

_BOUNDS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}


class SettingsField(NamedTuple):
    """A field of a file, or a table of fields."""

    path: str
    """Dotted path; `[]` stands for each entry of a list: `channel.jammers[].radius`."""
    type: str
    """`number`, `integer`, `boolean`, `string`, `table`, `list of ...`, or the permitted texts."""
    unit: str
    """SI unit, 1 for a ratio; empty for a field without a unit."""
    range: str
    """Bounds, such as `> 0, <= 20`; empty without bounds."""
    default: Any
    """Default as in JSON; None for a field without a default."""
    is_required: bool
    description: str


def json_schema(file: type[Table]) -> dict[str, Any]:
    """JSON schema of a `file`; each field has a description, and a `unit` if it has one."""
    schema = file.model_json_schema()
    for model in _models(file):
        table = schema if model is file else schema["$defs"][model.__name__]
        for name, text in _docstrings(model).items():
            description, unit = _split(text)
            table["properties"][model.model_fields[name].alias or name] |= {
                "description": description,
                **({"unit": unit} if unit else {}),
            }
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def fields(file: type[Table]) -> Iterator[SettingsField]:
    """All fields of a `file`, table by table."""
    schema = json_schema(file)
    yield from _fields(schema, schema["$defs"], "")


def _fields(table: dict[str, Any], tables: dict[str, Any], prefix: str) -> Iterator[SettingsField]:
    for name, entry in table["properties"].items():
        field = _without_null(entry)
        inner = _without_null(field.get("items", field))
        members = [tables[kind["$ref"].rpartition("/")[2]] for kind in _kinds(inner) if "$ref" in kind]
        path = f"{prefix}{name}" + ("[]" if members and inner is not field else "")
        yield SettingsField(
            path,
            _type(field),
            entry.get("unit", ""),
            ", ".join(f"{sign} {_number(field[key])}" for key, sign in _BOUNDS.items() if key in field),
            None if members and len(members) == len(_kinds(inner)) else entry.get("default"),
            name in table.get("required", ()),
            entry["description"],
        )
        if members:
            yield from _fields(_merged(members), tables, f"{path}.")


def _kinds(entry: dict[str, Any]) -> Sequence[dict[str, Any]]:
    """The members of a union; a value of one kind is its only member."""
    kinds: Sequence[dict[str, Any]] = entry.get("oneOf") or entry.get("anyOf") or [entry]
    return kinds


def _merged(members: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """One table with the fields of all members of a union. `index` tells which members have a field."""
    if len(members) == 1:
        return members[0]
    every = _indices(members)
    properties: dict[str, dict[str, Any]] = {}
    for name in dict.fromkeys(name for member in members for name in member["properties"]):
        owners = [member for member in members if name in member["properties"]]
        entries = [owner["properties"][name] for owner in owners]
        texts = dict.fromkeys(text for entry in entries for text in _texts(entry))
        indices = _indices(owners)
        only = f" Only with index {_listed(indices)}." if indices and indices != every else ""
        description = {"description": entries[0]["description"] + only}
        properties[name] = {**entries[0], **({"enum": list(texts)} if texts else {}), **description}
    required = [name for name in properties if all(name in member.get("required", ()) for member in members)]
    return {"properties": properties, "required": required}


def _indices(members: Sequence[dict[str, Any]]) -> list[str]:
    """The `index` of each member that has one."""
    return [text for member in members for text in _texts(member["properties"].get("index", {}))]


def _texts(entry: dict[str, Any]) -> list[str]:
    """The permitted texts of a field; none if it is not a choice of texts."""
    texts: list[str] = entry.get("enum") or ([entry["const"]] if "const" in entry else [])
    return texts


def _listed(texts: Sequence[str]) -> str:
    """Texts in words.

    >>> _listed(["oracle", "sampled"])
    '`oracle` or `sampled`'
    """
    return " or ".join(f"`{text}`" for text in texts)


def _without_null(entry: dict[str, Any]) -> dict[str, Any]:
    """The schema of a field's value if it is not null."""
    kinds = [kind for kind in entry.get("anyOf", ()) if kind != {"type": "null"}]
    return kinds[0] if len(kinds) == 1 else entry


def _type(field: dict[str, Any]) -> str:
    if "$ref" in field or field.get("type") == "object":
        return "table"
    if _texts(field):
        return ", ".join(f"`{text}`" for text in _texts(field))
    if "anyOf" in field or "oneOf" in field:
        return " or ".join(dict.fromkeys(_type(kind) for kind in _kinds(field) if kind != {"type": "null"}))
    if "prefixItems" in field:
        return f"list of {len(field['prefixItems'])} {_type(field['prefixItems'][0])}s"
    if "items" in field:
        kind, of, inner = _type(field["items"]).partition(" of ")
        return f"list of {kind}s{of}{inner}"
    return str(field.get("type", "any value"))


def _number(bound: float) -> str:
    return str(bound) if isinstance(bound, int) else f"{bound:g}"


def _split(text: str) -> tuple[str, str]:
    """A docstring without its unit in brackets, and the unit.

    >>> _split("x of its center [m; world frame].")
    ('x of its center (world frame).', 'm')
    """
    match = _UNIT.search(text)
    if match is None:
        return text, ""
    remark = f" ({match[2]})" if match[2] else ""
    return text[: match.start()] + remark + text[match.end() :], match[1]


def _models(model: type[Table]) -> Iterator[type[Table]]:
    """A model and all models in it."""
    yield model
    for field in model.model_fields.values():
        for kind in tables_within(field.annotation):
            yield from _models(kind)


def _docstrings(model: type[Table]) -> dict[str, str]:
    """Docstring of each field of a model, fields of its base classes included."""
    texts: dict[str, str] = {}
    for kind in reversed(model.__mro__):
        if issubclass(kind, Table):
            texts |= attribute_docstrings(kind)
    return texts


@cache
def attribute_docstrings(kind: type) -> dict[str, str]:
    """Docstring of each annotated attribute in the body of a class, in one line."""
    [definition] = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(definition, ast.ClassDef)
    texts = {}
    for statement, following in pairwise(definition.body):
        if not isinstance(statement, ast.AnnAssign) or not isinstance(statement.target, ast.Name):
            continue
        value = following.value if isinstance(following, ast.Expr) else None
        if isinstance(value, ast.Constant) and isinstance(value.value, str):
            texts[statement.target.id] = " ".join(value.value.split())
    return texts
