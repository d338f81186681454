"""A broken rule of a typed table, in one line."""

import difflib
import reprlib
from collections.abc import Iterable
from typing import Any, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from fes.model.table import Table
from fes.system.output import printable

LONGEST = 120
"""Longest text from outside in a message [characters]."""


def first_rule(error: ValidationError, model: type[Table], table: str, prefix: str = "") -> str:
    """The first broken rule of `model`: field, rule, offending value; for an unknown field the nearest known one.

    `table` names the model itself, `prefix` precedes its fields.
    """
    known = _fields(model, prefix)
    first, parts = _first(error, set(known), prefix)
    path = ".".join(map(str, parts))
    field = short(prefix + path) if path else table
    if first["type"] == "extra_forbidden":
        near = _nearest(_dotted(prefix, parts), known)
        hint = f"did you mean '{near}'?" if near else "fes schema lists the fields"
        return f"unknown field '{field}'; {hint}"
    message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if first["type"] == "missing":
        return f"{field}: is required"
    if first["type"] == "value_error":
        return f"{field}: {message}" if path else message
    return f"{field}: {message}, got {reprlib.repr(first['input'])}"


def short(text: str) -> str:
    """Text from outside, made safe to print: without control characters, and cut to LONGEST."""
    shown = printable(text[: LONGEST + 1])
    return shown if len(shown) <= LONGEST else shown[: LONGEST - 1] + "…"


def _first(error: ValidationError, known: set[str], prefix: str) -> tuple[ErrorDetails, list[str | int]]:
    """The error to report, and the parts of its field's path."""
    # an unknown field is reported first: it may be a required field, misspelt
    broken = sorted(error.errors(include_url=False), key=lambda details: details["type"] != "extra_forbidden")
    paths = [_path(details, known, prefix) for details in broken]
    # of the members of a union that failed, the one that got further was meant
    deeper = [place for place, path in enumerate(paths) if path[: len(paths[0])] == paths[0] != path]
    place = deeper[0] if deeper else 0
    return broken[place], paths[place]


def _path(details: ErrorDetails, known: set[str], prefix: str) -> list[str | int]:
    """The parts of an error's path that stand in the scenario: fields and places in lists, not members of unions."""
    parts: list[str | int] = []
    for place, part in enumerate(details["loc"], 1):
        is_unknown_field = details["type"] == "extra_forbidden" and place == len(details["loc"])
        if isinstance(part, int) or is_unknown_field or _dotted(prefix, [*parts, part]) in known:
            parts.append(part)
    return parts


def _dotted(prefix: str, parts: Iterable[str | int]) -> str:
    """A dotted path without places in lists."""
    return prefix + ".".join(part for part in parts if isinstance(part, str))


def _nearest(field: str, known: list[str]) -> str | None:
    """The nearest known field: one of the same table first, then one of the same name in another table.

    >>> _nearest("channel.snr", ["channel", "channel.reference_snr", "run.dt"])
    'channel.reference_snr'
    """
    table, _, name = field.rpartition(".")
    siblings = {path.rpartition(".")[2]: path for path in known if path.rpartition(".")[0] == table}
    others = {path.rpartition(".")[2]: path for path in known if "." in path}
    for names, cutoff in ((siblings, 0.6), (others, 1.0)):
        if near := difflib.get_close_matches(name, names, n=1, cutoff=cutoff):
            return names[near[0]]
    for names in (siblings, {} if table else others):
        if within := [longer for longer in names if name and name in longer]:
            return names[min(within, key=len)]
    near = difflib.get_close_matches(name, siblings, n=1, cutoff=0.55)
    return siblings[near[0]] if near else None


def _fields(model: type[Table], prefix: str) -> list[str]:
    """Dotted paths of all fields of a model and of the tables in it."""
    names = []
    for name, field in model.model_fields.items():
        dotted = f"{prefix}{field.alias or name}"
        names.append(dotted)
        for kind in tables_within(field.annotation):
            names += _fields(kind, f"{dotted}.")
    return list(dict.fromkeys(names))


def tables_within(annotation: Any) -> list[type[Table]]:
    """The tables in the type of a field: a table, an optional one, a list of them, or the members of a union."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return [annotation]
    return [table for part in get_args(annotation) for table in tables_within(part)]
