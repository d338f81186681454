"""A broken rule of a typed table, in one line."""

import difflib
import reprlib
from typing import get_args

from pydantic import ValidationError

from fes.config import Table

LONGEST = 120
"""Of a text of others in a message [characters]."""


def first_rule(error: ValidationError, model: type[Table], whole: str, prefix: str = "") -> str:
    """The first broken rule of `model`: field, rule, offending value; for an unknown field the nearest one.

    `whole` names the table itself, `prefix` goes before the fields in it.
    """
    # an unknown field goes first: it may be the missing one, misspelt
    first = min(error.errors(include_url=False), key=lambda found: found["type"] != "extra_forbidden")
    at = ".".join(str(part) for part in first["loc"])
    field = short(prefix + at) if at else whole
    if first["type"] == "extra_forbidden":
        near = difflib.get_close_matches(field, _fields(model, prefix), n=1, cutoff=0.4)
        return f"unknown field '{field}'" + (f"; did you mean '{near[0]}'?" if near else "")
    message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if first["type"] == "missing":
        return f"{field}: is required"
    if first["type"] == "value_error":
        return f"{field}: {message}" if at else message
    return f"{field}: {message}, got {reprlib.repr(first['input'])}"


def short(text: str) -> str:
    """A text of others as it can be printed: without control characters, and cut."""
    shown = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text[: LONGEST + 1])
    return shown if len(shown) <= LONGEST else shown[: LONGEST - 1] + "…"


def _fields(model: type[Table], prefix: str) -> list[str]:
    names = []
    for name, field in model.model_fields.items():
        dotted = f"{prefix}{field.alias or name}"
        names.append(dotted)
        # a table, an optional one, or a list of them
        for kind in (field.annotation, *get_args(field.annotation)):
            if isinstance(kind, type) and issubclass(kind, Table):
                names += _fields(kind, f"{dotted}.")
    return names
