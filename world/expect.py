"""What a scenario expects of its run, checked in the summary at the end: [[expect]] tables."""

import difflib
import math
from typing import Annotated, Any, Self

from pydantic import Field, field_validator, model_validator

from fes.config import Table

KEYS = (
    *("scenario", "seed", "backend", "clock", "robots", "ticks", "dt", "simulated_s", "wall_s", "ticks_per_s"),
    *("real_time_factor", "optimal_separation", "edges", "separation_error_max", "separation_error_rms"),
    *("disagreement", "estimate_error_max", "estimate_error_rms", "disk_connected_always", "links_connected_always"),
    *("algebraic_connectivity", "beacons_sent", "beacons_decoded", "time_to", "digest", "tracking", "radio"),
    *("deadlines", "links_gap_longest"),
)
"""What a summary tells."""

Bound = Annotated[float, Field(allow_inf_nan=False)]


class ExpectConfig(Table):
    """One expectation; all that is given must hold."""

    of: str = Field(min_length=1)
    """A key of the summary, by its dotted path, such as `time_to.estimate_1m` or `tracking.0.rmse`."""
    below: Bound | None = None
    above: Bound | None = None
    equals: bool | float | str | None = None

    @field_validator("of")
    @classmethod
    def _known(cls, of: str) -> str:
        key = of.partition(".")[0]
        if key not in KEYS:
            near = difflib.get_close_matches(key, KEYS, 1)
            raise ValueError(f"a summary has no {key[:60]!r}" + (f"; did you mean '{near[0]}'?" if near else ""))
        return of

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
