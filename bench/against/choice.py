"""The rows and the details that the command line names."""

from collections.abc import Iterable, Sequence

from bench.against.plan import Plan, Row
from bench.against.programs import NotMeasured
from bench.against.table import Line

DETAILS = "details"
"""Word for the figures beside the table."""


def words(rows: Iterable[Row]) -> list[str]:
    """All words that choose rows or the details."""
    listed = list(rows)
    groups = {group for row in listed for group in row.groups}
    return [*(row.name for row in listed), *sorted(groups), DETAILS]


def chosen(rows: Sequence[Row], only: str | None) -> tuple[list[Row], bool]:
    """The rows that `only` names, in their order, and True if it names the details; everything for None.

    `only` has names of rows and of groups, with commas between. Raises ValueError for another word.
    """
    if only is None:
        return list(rows), True
    named = [word.strip() for word in only.split(",")]
    unknown = [word for word in named if word not in words(rows)]
    if unknown:
        raise ValueError(f"--only: each word must be one of {', '.join(words(rows))}, got {unknown[0]!r}")
    picked = [row for row in rows if row.name in named or set(row.groups) & set(named)]
    return picked, DETAILS in named


def lines(row: Row, plan: Plan) -> list[Line]:
    """The lines of a row: one with the reason for each core that could not be measured."""
    missing = [_missing(row, core.name, core.reason) for core in plan.cores if core.reason]
    try:
        return [*missing, *row.measure(plan, row)]
    except NotMeasured as error:
        usable = [core for core in plan.cores if not core.reason]
        return [*missing, *(_missing(row, core.name, str(error)) for core in usable)]


def _missing(row: Row, core: str, reason: str) -> Line:
    return Line(row.what, core, row.wanted, core != "numpy", reason=reason)
