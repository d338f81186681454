"""What a scenario expects of its run, checked in the summary at the end: [[expect]] tables."""

import math
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from fes.config import Table

Bound = Annotated[float, Field(allow_inf_nan=False)]


class ExpectConfig(Table):
    """One expectation; all that is given must hold."""

    of: str = Field(min_length=1)
    """A key of the summary, by its dotted path, such as `time_to.estimate_1m` or `tracking.0.rmse`."""
    below: Bound | None = None
    above: Bound | None = None
    equals: bool | float | str | None = None

    @model_validator(mode="after")
    def _something(self) -> Self:
        if self.below is None and self.above is None and self.equals is None:
            raise ValueError("give at least one of below, above and equals")
        return self

    @property
    def rule(self) -> str:
        """What is expected, in words."""
        given = (("below", self.below), ("above", self.above), ("equal to", self.equals))
        return " and ".join(f"{word} {value}" for word, value in given if value is not None)


def verdicts(expected: list[ExpectConfig], summary: dict[str, Any]) -> list[dict[str, Any]]:
    """For each expectation `of`, `expected` (its rule), `seen` and whether it `holds`.

    What the summary does not have, or has as null, is seen as null and meets no bound.
    """
    return [
        {"of": one.of, "expected": one.rule, "seen": seen, "holds": _holds(one, seen)}
        for one, seen in ((one, _find(summary, one.of)) for one in expected)
    ]


def unmet(summary: dict[str, Any]) -> bool:
    """Whether an expectation of a summary does not hold."""
    return any(not verdict["holds"] for verdict in summary["expectations"])


def _find(summary: dict[str, Any], path: str) -> Any:
    found: Any = summary
    for part in path.split("."):
        if isinstance(found, dict):
            found = found.get(part)
        elif isinstance(found, list) and part.lstrip("-").isdigit() and -len(found) <= int(part) < len(found):
            found = found[int(part)]
        else:
            return None
    return found


def _holds(expected: ExpectConfig, seen: Any) -> bool:
    if expected.equals is not None and seen != expected.equals:
        return False
    if expected.below is None and expected.above is None:
        return True
    if isinstance(seen, bool) or not isinstance(seen, int | float) or not math.isfinite(seen):
        return False
    low = -math.inf if expected.above is None else expected.above
    high = math.inf if expected.below is None else expected.below
    return low < seen < high
