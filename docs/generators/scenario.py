"""Pages of files of settings: every table and field, with type, unit, range, default and meaning."""

import json

from docs.generators.markdown import code, prose, table
from fes.model.table import Table
from fes.settings.schema import SettingsField, fields

TITLE = "Scenario"
INTRODUCTION = """A scenario is one TOML file. This page lists every field that it can have. Unknown fields are
errors, and the message names the nearest known field. `--set a.b=c` overrides a field by its dotted path, and `fes
schema` prints the same information as JSON schema.

Rules that involve several fields are checked when the scenario is loaded. The error states the rule
and the offending value."""


ROBOT_TITLE = "robot.toml"
ROBOT_INTRODUCTION = """`fes-robot` reads its settings from one TOML file, which can serve a whole team: `{robot}` in
the name of a topic stands for the id of a robot. Unknown fields are errors, and the message names the nearest known
field. [Run on real robots](../how-to/robots.md) shows how to fill it in.

Lengths and speeds in `[body]` and `[limits]` are those of the body. In all other tables they are those of the law,
which are `body.scale` times as large."""


def page(file: type[Table]) -> list[str]:
    """The lines of the page of a `file`, without its title."""
    described = list(fields(file))
    about = {field.path: field.description for field in described}
    tables: dict[str, list[SettingsField]] = {}
    for field in described:
        tables.setdefault(field.path.rpartition(".")[0], []).append(field)
    lines: list[str] = []
    for path, group in tables.items():
        heading = f"`{_toml(path)}`" if path else "Top level"
        lines += [f"## {heading}", "", *([prose(about[path]), ""] if path else [])]
        lines += table(["field", "type", "unit", "range", "default", "meaning"], [_row(field) for field in group])
    return lines


def _toml(path: str) -> str:
    """The header of a table in TOML, such as [[channel.jammers]]."""
    return f"[[{path.removesuffix('[]')}]]" if path.endswith("[]") else f"[{path}]"


def _row(field: SettingsField) -> list[str]:
    default = "required" if field.is_required else "" if field.default is None else code(json.dumps(field.default))
    name = code(field.path.rpartition(".")[2].removesuffix("[]"))
    return [name, field.type, field.unit, field.range, default, prose(field.description)]
