"""fes.load: a scenario from a file or a name, with overrides."""

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from console.api import arguments
from fes.errors import ScenarioError
from fes.settings import toml
from fes.system import encoding
from world.config import builtin, scenario
from world.config.outside import schemes
from world.config.outside.schemes import NOTHING, Comparison
from world.config.scenario import Scenario

Source = Scenario | str | os.PathLike[str]
"""A scenario, the name of a built-in scenario, or the path of a file."""

Overrides = Mapping[str, Any]
"""Values of fields, by dotted path or in nested tables: {"run.seed": 3} or {"run": {"seed": 3}}.

A table with the key `use`, an extension and its parameters, is one value.
"""

UNNAMED = "scenario"
"""Name of a scenario that was given as an object."""


class NamedScenario(NamedTuple):
    """A scenario, and the name that logs and summaries give it."""

    name: str
    scenario: Scenario


def load(
    name_or_path: str | os.PathLike[str], overrides: Overrides | None = None, *, use: Iterable[str] = ()
) -> Scenario:
    """A scenario: typed, frozen and complete.

    `name_or_path` is the name of a built-in scenario, such as "paper", or the path of a TOML file. `overrides` give
    fields other values: by dotted path, {"run.seed": 3}, or in nested tables, {"run": {"seed": 3}}. Values are those
    of TOML; numpy arrays count as lists. A table with the key `use` is one value, which replaces the former one:
    {"formation.law": {"use": "voronoi", "gain": 2.0}}. The name of the file's own extension keeps its parameters.

    `use` names modules, or files of modules, whose extensions the scenario may name as `module:Class`. "__main__" is
    the notebook or script itself, for runs in one loop.

    Raises ScenarioError, a FesError of one line: the field, the rule and the offending value.
    """
    with arguments.checked():
        arguments.allow(use)
        return resolve(name_or_path, flat(overrides)).scenario


def resolve(source: Source, fields: dict[str, Any], name: str | None = None) -> NamedScenario:
    """The scenario of a source with other values of `fields`, each by its dotted path; raises ScenarioError."""
    name = None if name is None else encoding.check_name(name)
    if isinstance(source, Scenario):
        return NamedScenario(name or UNNAMED, scenario.with_overrides(source, fields) if fields else source)
    if not isinstance(source, str | os.PathLike):
        raise ScenarioError("scenario", f"expects a Scenario, a name or a path, got {type(source).__name__}")
    path = builtin.resolve(Path(source))
    return NamedScenario(name or encoding.name_of(path), scenario.load(path, fields))


def comparison(source: Source) -> Comparison:
    """The schemes of a source's file; raises ScenarioError."""
    return NOTHING if isinstance(source, Scenario) else schemes.of_file(builtin.resolve(Path(source)))


def flat(overrides: Overrides | None) -> dict[str, Any]:
    """Overrides by dotted path, with values of TOML; raises ScenarioError.

    >>> flat({"run": {"seed": 3}, "run.dt": 0.01, "seeking": {"use": "krstic_wang"}})
    {'run.seed': 3, 'run.dt': 0.01, 'seeking': {'use': 'krstic_wang'}}
    """
    return dict(_flat("", overrides or {}, 0))


def plain(value: Any, where: str) -> Any:
    """A value as TOML has it: numbers and arrays of numpy, and tuples, become Python's own; raises ScenarioError.

    >>> plain(np.arange(2), "x"), plain((1, np.float64(2.0)), "x")
    ([0, 1], [1, 2.0])
    """
    value = _plain(value, where, 0)
    try:
        toml.check(value)
    except ValueError as error:
        raise ScenarioError("overrides", f"'{where}' {error}") from None
    return value


def _flat(prefix: str, overrides: Overrides, depth: int) -> Iterator[tuple[str, Any]]:
    if not isinstance(overrides, Mapping):
        raise ScenarioError("overrides", f"expects a dict, got {type(overrides).__name__}")
    for field, value in overrides.items():
        if not isinstance(field, str):
            raise ScenarioError("overrides", f"expects names of fields, got {field!r:.40}")
        if isinstance(value, Mapping) and "use" not in value:
            _check_depth(prefix + field, depth)
            yield from _flat(f"{prefix}{field}.", value, depth + 1)
        else:
            yield prefix + field, plain(value, prefix + field)


def _plain(value: Any, where: str, depth: int) -> Any:
    _check_depth(where, depth)
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {key: _plain(item, where, depth + 1) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item, where, depth + 1) for item in value]
    return value


def _check_depth(where: str, depth: int) -> None:
    if depth > encoding.DEEPEST:
        raise ScenarioError("overrides", f"'{where:.40}' is nested too deeply")
