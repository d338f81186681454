"""Tables about the summary of a run: further metrics in it, [[metric]], and what is expected of it, [[expect]]."""

import difflib
import math
import re
import reprlib
from typing import Annotated, Any, Self

from pydantic import Field, field_validator, model_validator

from fes.model import quantities
from fes.model.quantities import FLAG, NUMBER, TEXT, Shape
from fes.model.table import Table, Use

_SUMMARY = {key: part for key, part in quantities.shape().items() if key != quantities.VERDICTS}
"""Shape of a summary; each part of it may also be null."""

_INDEX = re.compile(r"-?[0-9]{1,9}")

Bound = Annotated[float, Field(allow_inf_nan=False)]


class MetricConfig(Use):
    """A metric, with its parameters."""

    name: Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,39}$")] | None = None
    """Name under `metrics` in the summary, of one metric only; by default that of the extension."""

    @property
    def choice(self) -> Use:
        """The extension and its parameters."""
        return Use.model_validate({"use": self.use, **self.parameters})

    @property
    def key(self) -> str:
        """Name under `metrics` in the summary."""
        return self.name or self.use.rpartition(":")[2].rpartition(".")[2]


class ExpectConfig(Table):
    """One expectation; all bounds that are given must hold."""

    of: str = Field(min_length=1)
    """Key of the summary, by its dotted path, such as `time_to.estimate_1m` or `tracking.0.rmse`."""
    below: Bound | None = None
    """Upper bound of the value, exclusive; in the unit of the key."""
    above: Bound | None = None
    """Lower bound of the value, exclusive; in the unit of the key."""
    equals: bool | float | str | None = None
    """Value that the key must have; in the unit of the key."""

    @field_validator("of")
    @classmethod
    def _known(cls, of: str) -> str:
        shape_at(of)
        return of

    @model_validator(mode="after")
    def _possible(self) -> Self:
        """Reject, before a run that may take hours, an expectation that no summary can meet."""
        bounded, wanted, shape = self.below is not None or self.above is not None, self.equals, shape_at(self.of)
        if not bounded and wanted is None:
            raise ValueError("give at least one of below, above and equals")
        if not isinstance(shape, str):
            raise ValueError(f"'{self.of}' is not a single value: name one in it, such as '{_first_scalar(self.of)}'")
        if bounded and shape != NUMBER:
            raise ValueError(f"'{self.of}' is {shape}: give equals")
        if wanted is not None and not _can_equal(shape, wanted):
            raise ValueError(f"'{self.of}' is {shape}, and never equal to {reprlib.repr(wanted)}")
        if self.below is not None and self.above is not None and self.above >= self.below:
            raise ValueError(f"no value is above {self.above} and below {self.below}")
        if wanted is not None and not _holds(self, wanted):
            raise ValueError(f"no value is {self.rule}")
        return self

    @property
    def rule(self) -> str:
        """The expectation, in words."""
        given = (("below", self.below), ("above", self.above), ("equal to", self.equals))
        return " and ".join(f"{word} {value}" for word, value in given if value is not None)


def check(expected: list[ExpectConfig], is_live: bool, has_team_index: bool) -> None:
    """Raise ValueError in one line for an expectation of a key that the summary of the run will not have."""
    for expectation in expected:
        if expectation.of.startswith("deadlines") and not is_live:
            raise ValueError(f"expect: '{expectation.of}' exists with a live clock only (run.clock)")
        if expectation.of in quantities.OPTIONAL and not has_team_index:
            asked = "where a configuration is sought, or with objective.team_index = true"
            raise ValueError(f"expect: '{expectation.of}' exists only {asked}")


def shape_at(path: str) -> Shape:
    """Shape of the part of a summary at a dotted path; raises ValueError if no summary has such a part."""
    shape: Shape = _SUMMARY
    parts = path.split(".")
    for position, part in enumerate(parts):
        before = ".".join(parts[:position])
        if isinstance(shape, str):
            raise ValueError(f"'{before}' is {shape}, and has no {part[:60]!r}")
        if isinstance(shape, dict):
            key = f"{before}.{part[:60]}" if before else part[:60]
            if "*" in shape:
                shape = shape["*"]
                continue
            if part not in shape:
                near = difflib.get_close_matches(part, shape, 1)
                hint = f"; did you mean '{before}{'.' * bool(before)}{near[0]}'?" if near else ""
                raise ValueError(f"a summary has no {key!r}{hint}")
            shape = shape[part]
        elif not _INDEX.fullmatch(part):
            raise ValueError(f"'{before}' is a list: give the index of an entry, from 0, got {part[:60]!r}")
        elif isinstance(shape, list):
            shape = shape[0]
        elif -len(shape) <= int(part) < len(shape):
            shape = shape[int(part)]
        else:
            raise ValueError(f"'{before}' has {len(shape)} entries, no {part!r}")
    return shape


def _first_scalar(path: str) -> str:
    """Path of the first scalar in the part at `path`."""
    while not isinstance(shape := shape_at(path), str):
        path += f".{next(iter(shape))}" if isinstance(shape, dict) else ".0"
    return path


def _can_equal(shape: str, value: bool | float | str) -> bool:
    """True if a scalar of this kind can be equal to the value."""
    if isinstance(value, str):
        return shape == TEXT
    return value in (True, False) if shape == FLAG else shape == NUMBER and math.isfinite(value)


def verdicts(expected: list[ExpectConfig], summary: dict[str, Any]) -> list[dict[str, Any]]:
    """One table per expectation: `of`, `expected` (its rule), `seen` (the value) and `holds`.

    A value that the summary lacks, or has as null, is seen as null and meets no bound.
    """
    seen = [_value(summary, expectation.of) for expectation in expected]
    return [
        {"of": expectation.of, "expected": expectation.rule, "seen": value, "holds": _holds(expectation, value)}
        for expectation, value in zip(expected, seen, strict=True)
    ]


def unmet(summary: dict[str, Any]) -> bool:
    """True if an expectation of a summary does not hold."""
    return any(not verdict["holds"] for verdict in summary["expectations"])


def _value(summary: dict[str, Any], path: str) -> Any:
    """The value at a dotted path of a summary, or None."""
    value: Any = summary
    for part in path.split("."):
        if isinstance(value, dict):
            value = value.get(part)
        elif isinstance(value, list) and -len(value) <= int(part) < len(value):
            value = value[int(part)]
        else:
            return None
    return value


def _holds(expected: ExpectConfig, seen: Any) -> bool:
    """True if a value meets all bounds of an expectation."""
    if expected.equals is not None and seen != expected.equals:
        return False
    if expected.below is None and expected.above is None:
        return True
    if isinstance(seen, bool) or not isinstance(seen, int | float) or not math.isfinite(seen):
        return False
    low = -math.inf if expected.above is None else expected.above
    high = math.inf if expected.below is None else expected.below
    return low < seen < high
