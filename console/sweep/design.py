"""The design of an experiment: the cells of a full factorial of axes, each run with the same seeds.

The channel's draws depend on (seed, stream, tick, pair) only, so runs with one seed face the same radio in every
cell: common random numbers.
"""

import hashlib
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from console.backends import inprocess
from fes.errors import ScenarioError
from fes.settings.validation import short
from fes.system import encoding, strict_json
from world.config.outside import extensions, schemes
from world.config.outside.schemes import NOTHING, SCHEME, ColumnConfig, Comparison
from world.config.overrides import value_at
from world.config.scenario import Scenario, load, parse_override
from world.simulation import crowd

SEED = "run.seed"
MAX_RUNS = 1_000_000
"""Largest number of runs of a sweep."""

_BRACKETS = {"[": 1, "{": 1, "]": -1, "}": -1}

Value = str | int | float | bool | None


@dataclass(frozen=True, eq=False)
class Cell:
    """One combination of the axes' values."""

    values: tuple[Value, ...]
    """Values in the scenario, one per axis; a list as its JSON, an extension as its name."""
    scenario: Scenario


@dataclass(frozen=True, eq=False)
class SweepRun:
    """One row of the table."""

    cell: int
    seed: int
    scenario: Scenario

    @cached_property
    def key(self) -> str:
        """Unique key of the run: SHA-256 of its complete scenario, defaults included."""
        return digest(self.scenario)


@dataclass(frozen=True, eq=False)
class Design:
    """All cells and seeds of a sweep."""

    name: str
    axes: tuple[str, ...]
    cells: list[Cell]
    seeds: list[int]
    columns: tuple[ColumnConfig, ...] = ()
    """Columns of the table of schemes, if the scenario file has any."""

    @cached_property
    def runs(self) -> list[SweepRun]:
        """All runs, cell by cell in the order of the axes, and by seed within a cell."""
        return [
            SweepRun(index, seed, seeded(cell.scenario, seed))
            for index, cell in enumerate(self.cells)
            for seed in self.seeds
        ]

    def values(self, axis: int) -> list[Value]:
        """The values of an axis, in their given order."""
        return list(dict.fromkeys(cell.values[axis] for cell in self.cells))

    def title(self, cell: int) -> str:
        """A label of a cell: its values."""
        return ", ".join(map(str, self.cells[cell].values)) or self.name

    def contrast(self, axis: int, base: int, compared: int) -> tuple[str, str]:
        """Labels of the difference of two cells along an axis, and of the values of the other axes."""
        before, after = self.cells[base].values, self.cells[compared].values
        return f"{after[axis]} - {before[axis]}", ", ".join(map(str, (*after[:axis], *after[axis + 1 :])))


def plan(path: Path, axes: list[str], seeds: str, settings: list[str]) -> Design:
    """The design given by the arguments of fes sweep; the scenario of every cell is checked.

    Raises ScenarioError.
    """
    fixed = dict(map(parse_override, settings))
    fields: dict[str, list[Any]] = {}
    for text in axes:
        field, values = parse_axis(text)
        if field in fields:
            raise ScenarioError("--axis", f"expects each field once, got '{short(field)}' again")
        fields[field] = values
    name, numbers, compared = encoding.name_of(path), parse_seeds(seeds), schemes.of_file(path)
    return crossed(name, lambda settings: load(path, settings), fixed, fields, numbers, compared)


def crossed(
    name: str,
    make: Callable[[dict[str, Any]], Scenario],
    fixed: dict[str, Any],
    fields: dict[str, list[Any]],
    seeds: list[int],
    compared: Comparison = NOTHING,
) -> Design:
    """The design that crosses the values of these `fields`, each by its dotted path, with the `seeds`.

    `make` makes a scenario from overrides: the `fixed` ones, and those of a cell. The scenario of every cell is
    checked. The schemes of a file are the first axis, unless a field or a fixed one chooses among them. Raises
    ScenarioError, and FesError for an extension that no worker can import.
    """
    if compared.scheme and SCHEME not in fields.keys() | fixed.keys():
        fields = {SCHEME: [scheme.name for scheme in compared.scheme], **fields}
    for field in fields.keys() & fixed.keys():
        raise ScenarioError("--axis", f"'{short(field)}' is given by --set, and cannot be an axis too")
    if SEED in fields or SEED in fixed:
        raise ScenarioError("--seeds", f"sets the seeds: '{SEED}' can be neither an axis nor in --set")
    count = len(seeds)
    for values in fields.values():
        count *= len(values)
    if count > MAX_RUNS:
        raise ScenarioError("fes sweep", f"makes at most {MAX_RUNS} runs, got {count}")
    cells = []
    for combination in itertools.product(*fields.values()):
        scenario = make({**fixed, **dict(zip(fields, combination, strict=True))})
        inprocess.check(scenario)
        crowd.check(scenario)
        extensions.check_importable(scenario)
        given = zip(fields, combination, strict=True)
        cells.append(Cell(tuple(_value(scenario, field, value) for field, value in given), scenario))
    design = Design(name, tuple(fields), cells, seeds, tuple(compared.column))
    for index, (field, values) in enumerate(fields.items()):
        if len(design.values(index)) < len(values):
            raise ScenarioError("--axis", f"expects each value of '{field}' once, got {', '.join(map(str, values))}")
    return design


def parse_axis(text: str) -> tuple[str, list[Any]]:
    """Parse an `--axis` argument `a.b=v1,v2` to its path and TOML values; bare words are strings.

    Raises ScenarioError.

    >>> parse_axis("formation.rule=disk,two_nearest")
    ('formation.rule', ['disk', 'two_nearest'])
    >>> parse_axis("seeking.initial_estimate=[50.0, 90.0],[60.0, 60.0]")
    ('seeking.initial_estimate', [[50.0, 90.0], [60.0, 60.0]])
    """
    field, equals, raw = text.partition("=")
    pieces = _split(raw)
    if not equals or not field.strip() or not all(piece.strip() for piece in pieces):
        raise ScenarioError("--axis", f"expects table.field=value,value, got '{short(text)}'")
    return field.strip(), [parse_override(f"{field}={piece.strip()}")[1] for piece in pieces]


def parse_seeds(text: str) -> list[int]:
    """Parse the argument of --seeds: `A:B` for A to B - 1, or a list; raises ScenarioError.

    >>> parse_seeds("2:5"), parse_seeds("7,1")
    ([2, 3, 4], [7, 1])
    """
    first, colon, end = text.partition(":")
    try:
        seeds = range(int(first), int(end)) if colon else [int(part) for part in text.split(",")]
    except ValueError:
        seeds = []
    if len(seeds[: MAX_RUNS + 1]) > MAX_RUNS:
        raise ScenarioError("--seeds", f"lists at most {MAX_RUNS} seeds, got '{short(text)}'")
    if not seeds or min(seeds) < 0 or max(seeds) >= 2**63:
        raise ScenarioError("--seeds", f"expects A:B with 0 <= A < B, or a list such as 1,2,5, got '{short(text)}'")
    if len(set(seeds)) < len(seeds):
        raise ScenarioError("--seeds", f"expects each seed once, got '{short(text)}'")
    return list(seeds)


def seeded(scenario: Scenario, seed: int) -> Scenario:
    """The scenario with another seed."""
    return scenario.model_copy(update={"run": scenario.run.model_copy(update={"seed": seed})})


def digest(scenario: Scenario) -> str:
    """SHA-256 of a complete scenario."""
    tables = scenario.model_dump(mode="json", by_alias=True)
    return hashlib.sha256(strict_json.dumps(tables, sort_keys=True).encode()).hexdigest()


def _split(raw: str) -> list[str]:
    """The pieces between commas outside brackets and strings."""
    pieces, depth, quote = [""], 0, ""
    for letter in raw:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        depth += 0 if quote else _BRACKETS.get(letter, 0)
        if letter == "," and depth == 0 and not quote:
            pieces.append("")
        else:
            pieces[-1] += letter
    return pieces


def _value(scenario: Scenario, field: str, given: Any) -> Value:
    """The value of a field; an extension is its name, with parameters if the axis gives them."""
    if field == SCHEME:
        return str(given)
    value = value_at(scenario.model_dump(mode="json", by_alias=True), field)
    if isinstance(value, dict):
        if "use" not in value:
            raise ScenarioError("--axis", f"expects a field, and '{field}' is a table")
        if given == value["use"]:
            return str(given)
        parameters = (f"{name}={strict_json.dumps(entry)}" for name, entry in value.items() if name != "use")
        return f"{value['use']}({', '.join(parameters)})"
    return strict_json.dumps(value) if isinstance(value, list) else value
