"""Schemes: named variants of one scenario file, which fes sweep compares, and the columns of their table.

The other tables of a file with `[[scheme]]` are a scenario like any other. Each scheme changes some of its fields.
The override `scheme` chooses a scheme.
"""

import copy
import difflib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from fes.errors import ScenarioError
from fes.model.table import Positive, Table
from fes.settings import toml
from fes.settings.validation import first_rule, short

SCHEME = "scheme"
"""The override that chooses a scheme, and the axis of a sweep of schemes."""


class SchemeConfig(Table):
    """A variant of the scenario."""

    name: Annotated[str, Field(min_length=1, max_length=60)]
    """Name of the scheme."""
    set: dict[str, Any] = Field(default={})
    """Fields that the scheme sets, by dotted path. A path to a table replaces the table."""


class ColumnConfig(Table):
    """A column of the table of schemes."""

    of: Annotated[str, Field(min_length=1, max_length=200)]
    """Number of the summary that the column shows, by dotted name, such as `metrics.travel.mean`."""
    title: Annotated[str, Field(min_length=1, max_length=60)]
    """Title of the column, with its unit."""
    factor: Positive = 1.0
    """Factor by which the number is multiplied [1]: 0.0001 shows an area in hectares."""
    better: Literal["larger", "smaller"] = "larger"
    """Direction in which a scheme is better."""


class Comparison(Table):
    """The schemes of a file, and the columns of their table."""

    scheme: list[SchemeConfig] = Field(default=[])
    """Variants of the scenario, which `fes sweep` compares."""
    column: list[ColumnConfig] = Field(default=[])
    """Columns of the table of schemes; by default every number of `summary.metrics`."""

    @model_validator(mode="after")
    def _named_once(self) -> "Comparison":
        names = [scheme.name for scheme in self.scheme]
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise ValueError(f"scheme: expects each name once, got '{twice[0]}' again")
        return self

    def settings(self, name: Any, where: str) -> dict[str, Any]:
        """The fields that a scheme sets; raises ScenarioError for a name that no scheme has."""
        names = [scheme.name for scheme in self.scheme]
        if name in names:
            return copy.deepcopy(self.scheme[names.index(name)].set)
        near = difflib.get_close_matches(str(name), names, 1)
        known = f"did you mean '{near[0]}'?" if near else f"it has {', '.join(names) or 'none'}"
        raise ScenarioError(where, f"there is no scheme '{short(str(name))}'; {known}")


NOTHING = Comparison()
"""The comparison of a file without schemes."""


def take(tables: dict[str, Any], where: str) -> Comparison:
    """The comparison of a file, taken out of its `tables`; raises ScenarioError, which names their origin `where`."""
    given = {name: tables.pop(name) for name in Comparison.model_fields if name in tables}
    try:
        return Comparison.model_validate(given)
    except ValidationError as error:
        raise ScenarioError(where, first_rule(error, Comparison, "scenario")) from None


def of_file(path: Path) -> Comparison:
    """The comparison of a TOML file; raises ScenarioError."""
    return take(toml.read(path), str(path))
