"""The command fes compare: where two recorded runs first differ."""

import itertools
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from console import log as logs
from console.difference import Difference, between
from console.log import Log, Tick
from fes import process

MISSING = "nothing"


def compare(
    first: Annotated[Path, typer.Argument(metavar="A", help="A log, run.mcap, or a run directory.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="Another one.")],
    json_: Annotated[bool, typer.Option("--json", help="Print the differences as JSON, and nothing else.")] = False,
) -> int:
    """Say where two recorded runs first differ: exit code 0 if they do not, 1 if they do."""
    one, other = logs.load(first), logs.load(second)
    settings = list(of_scenarios(one, other))
    found = first_difference(one, other)
    if json_:
        told = found._asdict() if found else None
        print(json.dumps({"scenario": [list(setting) for setting in settings], "first": told}))
    else:
        for path, mine, theirs in settings:
            print(f"scenario, {path}: {mine!r} in A and {theirs!r} in B")
        print(found.told("in A", "in B") if found else "every message of every tick is the same to the bit")
    return process.FAILURE if settings or found else process.SUCCESS


def of_scenarios(one: Log, other: Log) -> Iterator[tuple[str, Any, Any]]:
    """Dotted path and both values of each field in which the scenarios differ."""
    mine, theirs = (_fields(log.scenario.model_dump(mode="json", by_alias=True), "") for log in (one, other))
    a, b = dict(mine), dict(theirs)
    for path in [*a, *(path for path in b if path not in a)]:
        values = a.get(path, MISSING), b.get(path, MISSING)
        if values[0] != values[1]:
            yield path, *values


def first_difference(one: Log, other: Log) -> Difference | None:
    """The first tick, robot and field in which two logs differ; the end of one of them is a difference, too."""
    for tick, pair in enumerate(itertools.zip_longest(one.ticks(), other.ticks())):
        found = _of_ticks(tick, *pair)
        if found is not None:
            return found
    return None


def _of_ticks(number: int, one: Tick | None, other: Tick | None) -> Difference | None:
    if one is None or other is None:
        return Difference(number, "run", None, "this tick", *("there" if tick else MISSING for tick in (one, other)))
    found = between(number, one.said, other.said)
    if found is None and one.changes != other.changes:
        return Difference(number, "events", None, "what was set", one.changes, other.changes)
    return found


def _fields(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Dotted path and value of each field of a table, and of the tables in it."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _fields(inner, f"{path}.{name}" if path else name)
    else:
        yield path, value
