"""The page of the summary: every quantity, with its kind, unit and meaning."""

from docs.generators.markdown import code, prose, table
from fes.model.quantities import SUMMARY, Quantity

TITLE = "Summary"
INTRODUCTION = """`summary.json` in the run directory, and `fes run --json` on standard output, hold one JSON
object. Its keys are stable: scripts may rely on them. A quantity that does not exist, or is not finite, is null. An
`[[expect]]` table of a [scenario](scenario.md#expect) names a quantity by its dotted path, such as
`time_to.estimate_1m` or `tracking.0.rmse`."""

NOTES = """`expectations` has one entry per `[[expect]]` table: `of`, `expected` (the rule in words), `seen` and
`holds`.

A level of `time_to` counts as reached if it holds for 10 s, or to the end if the run ends sooner. It is null if it
is never reached. r\\* is computed from the channel's formula alone, without the
[effects](../how-to/change-the-channel.md#choose-the-channel) that a scenario may add to it. Separations of a
formation with a physical dither are averaged over a period of the dither.

**The digest** is the SHA-256 over all ticks in order. Each tick contributes its number as int64. Then each robot,
in id order, contributes x, y, heading, linear and angular as float64: the pose at the tick, and the twist held
after it. All numbers are little-endian. The digest is the same for the same scenario, seed and version of fes: on
every processor, with every numpy, in every backend and placement, in any start order, under any load."""


def page() -> list[str]:
    """The lines of the page, without its title."""
    rows = [_row(quantity) for quantity in SUMMARY]
    return [*table(["quantity", "kind", "unit", "meaning", "null if"], rows), NOTES, ""]


def _row(quantity: Quantity) -> list[str]:
    kind = quantity.kind.removeprefix("a ")
    return [code(quantity.name), kind, quantity.unit, prose(quantity.description), quantity.null]
