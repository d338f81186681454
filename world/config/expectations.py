"""What a scenario expects of its run, checked in the summary at the end: [[expect]] tables."""

import difflib
import math
import re
import reprlib
from typing import Annotated, Any, Self

from pydantic import Field, field_validator, model_validator

from fes.model.config import Table

NUMBER, FLAG, TEXT = "a number", "true or false", "a text"

Shape = str | list["Shape"] | tuple["Shape", ...] | dict[str, "Shape"]
"""A scalar by its kind, a list of any length by what it holds, a row by its columns, or a table."""

STRETCH: Shape = dict.fromkeys(
    ("at", "optimal_separation", "time_to_1m", "bias", "rmse", "separation_rmse", "disagreement_max", "index"), NUMBER
)

SUMMARY: dict[str, Shape] = {
    **dict.fromkeys(("scenario", "backend", "clock", "digest"), TEXT),
    **dict.fromkeys(("disk_connected_always", "links_connected_always"), FLAG),
    **dict.fromkeys(("seed", "robots", "ticks", "dt", "simulated_s", "wall_s", "ticks_per_s"), NUMBER),
    **dict.fromkeys(("real_time_factor", "optimal_separation", "disagreement", "algebraic_connectivity"), NUMBER),
    **dict.fromkeys(("separation_error_max", "separation_error_rms"), NUMBER),
    **dict.fromkeys(("estimate_error_max", "estimate_error_rms"), NUMBER),
    **dict.fromkeys(("beacons_sent", "beacons_decoded", "links_gap_longest"), NUMBER),
    **dict.fromkeys(("links_lost_at", "unscheduled_absences"), NUMBER),
    "time_to": dict.fromkeys(
        ("disagreement_1m", "estimate_1m", "estimate_0_1m", "separation_1m", "separation_0_1m"), NUMBER
    ),
    "tracking": [STRETCH],
    "deadlines": {
        **{key: [NUMBER] for key in ("due", "missed", "stopped", "late")},
        **dict.fromkeys(("missed_share", "slipped_s"), NUMBER),
    },
    "arithmetic": dict.fromkeys(("fingerprint", "numpy", "core"), TEXT),
    "edges": [(NUMBER,) * 5],
    "radio": [(NUMBER,) * 6],
}
"""What a summary tells; each of it may also be null."""

_PLACE = re.compile(r"-?[0-9]{1,9}")

Bound = Annotated[float, Field(allow_inf_nan=False)]


class ExpectConfig(Table):
    """One expectation; all that is given must hold."""

    of: str = Field(min_length=1)
    """A key of the summary, by its dotted path, such as `time_to.estimate_1m` or `tracking.0.rmse`."""
    below: Bound | None = None
    """The value must be below this."""
    above: Bound | None = None
    """The value must be above this."""
    equals: bool | float | str | None = None
    """The value must be equal to this."""

    @field_validator("of")
    @classmethod
    def _known(cls, of: str) -> str:
        shape_at(of)
        return of

    @model_validator(mode="after")
    def _possible(self) -> Self:
        """Refuse what holds of no summary: who runs for an hour is not to learn of it then."""
        bounded, wanted, shape = self.below is not None or self.above is not None, self.equals, shape_at(self.of)
        if not bounded and wanted is None:
            raise ValueError("give at least one of below, above and equals")
        if not isinstance(shape, str):
            raise ValueError(f"'{self.of}' is no single value: name one in it, such as '{_within(self.of)}'")
        if bounded and shape != NUMBER:
            raise ValueError(f"'{self.of}' is {shape}: give equals")
        if wanted is not None and not _is(shape, wanted):
            raise ValueError(f"'{self.of}' is {shape}, and never equal to {reprlib.repr(wanted)}")
        if self.below is not None and self.above is not None and self.above >= self.below:
            raise ValueError(f"nothing is above {self.above} and below {self.below}")
        if wanted is not None and not _holds(self, wanted):
            raise ValueError(f"nothing is {self.rule}")
        return self

    @property
    def rule(self) -> str:
        """What is expected, in words."""
        given = (("below", self.below), ("above", self.above), ("equal to", self.equals))
        return " and ".join(f"{word} {value}" for word, value in given if value is not None)


def shape_at(path: str) -> Shape:
    """What a summary has at a dotted path; raises ValueError where no summary has anything."""
    shape: Shape = SUMMARY
    parts = path.split(".")
    for at, part in enumerate(parts):
        before = ".".join(parts[:at])
        if isinstance(shape, str):
            raise ValueError(f"'{before}' is {shape}, and has no {part[:60]!r}")
        if isinstance(shape, dict):
            whole = f"{before}.{part[:60]}" if before else part[:60]
            if part not in shape:
                near = difflib.get_close_matches(part, shape, 1)
                hint = f"; did you mean '{before}{'.' * bool(before)}{near[0]}'?" if near else ""
                raise ValueError(f"a summary has no {whole!r}{hint}")
            shape = shape[part]
        elif not _PLACE.fullmatch(part):
            raise ValueError(f"'{before}' is a list: give the place of an entry, from 0, got {part[:60]!r}")
        elif isinstance(shape, list):
            shape = shape[0]
        elif -len(shape) <= int(part) < len(shape):
            shape = shape[int(part)]
        else:
            raise ValueError(f"'{before}' has {len(shape)} entries, no {part!r}")
    return shape


def _within(path: str) -> str:
    """The path of a scalar below one."""
    while not isinstance(shape := shape_at(path), str):
        path += f".{next(iter(shape))}" if isinstance(shape, dict) else ".0"
    return path


def _is(shape: str, value: bool | float | str) -> bool:
    """Whether a scalar of this kind can be equal to a value."""
    if isinstance(value, str):
        return shape == TEXT
    return value in (True, False) if shape == FLAG else shape == NUMBER and math.isfinite(value)


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
        elif isinstance(found, list) and -len(found) <= int(part) < len(found):
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
