"""A broken rule of a typed table, in one line."""

import difflib
import reprlib
from typing import get_args

from pydantic import ValidationError

from fes.model.table import Table
from fes.system.output import printable

LONGEST = 120
"""Longest text from outside in a message [characters]."""


def first_rule(error: ValidationError, model: type[Table], table: str, prefix: str = "") -> str:
    """The first broken rule of `model`: field, rule, offending value; for an unknown field the nearest known one.

    `table` names the model itself, `prefix` precedes its fields.
    """
    # an unknown field is reported first: it may be a required field, misspelt
    first = min(error.errors(include_url=False), key=lambda broken: broken["type"] != "extra_forbidden")
    path = ".".join(str(part) for part in first["loc"])
    field = short(prefix + path) if path else table
    if first["type"] == "extra_forbidden":
        plain = prefix + ".".join(str(part) for part in first["loc"] if not isinstance(part, int))
        near = _nearest(plain, _fields(model, prefix))
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
        # a table, an optional one, or a list of them
        for kind in (field.annotation, *get_args(field.annotation)):
            if isinstance(kind, type) and issubclass(kind, Table):
                names += _fields(kind, f"{dotted}.")
    return names
