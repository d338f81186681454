"""The tables of `--verbose`: tracking, links, beacons and expectations of a run."""

from collections.abc import Iterable
from typing import Any

from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from console.dashboard.summary_words import seen, shown_number, verdict
from console.terminal.formatting import UNKNOWN, percent
from console.terminal.printing import cell

MAX_EDGES = 30
MAX_CONTACTS = 5

_TRACKING = (
    ("at", "from", "{:,.2f} s"),
    ("optimal_separation", "r*", "{:.3f}"),
    ("time_to_1m", "1 m after", "{:,.2f} s"),
    ("bias", "bias", "{:+.3f}"),
    ("rmse", "rmse", "{:.3f}"),
    ("separation_rmse", "separation rmse", "{:.3f}"),
    ("disagreement_max", "disagreement", "{:.3g}"),
    ("index", "J", "{:.4f}"),
)
"""Columns: key in a row of the summary's tracking, heading and format."""


def tables(summary: dict[str, Any]) -> list[RenderableType]:
    """The tables, one below the other; those without rows are omitted."""
    made = [_tracking(summary["tracking"]), _edges(summary["edges"]), _radio(summary), _expectations(summary)]
    return [part for table in made if table for part in (*table, "")]


def _tracking(rows: list[dict[str, Any]]) -> list[RenderableType]:
    """The mean estimate against r*, without empty columns."""
    columns = [column for column in _TRACKING if any(row[column[0]] is not None for row in rows)]
    table = _table([heading for _, heading, _ in columns])
    for row in rows:
        table.add_row(*(UNKNOWN if row[key] is None else form.format(row[key]) for key, _, form in columns))
    return [_title("The mean estimate, in m, from the start and from each change of the channel"), table]


def _edges(edges: list[list[Any]]) -> list[RenderableType]:
    table = _table(["link", "separation [m]", "estimate [m]", "estimate back [m]"])
    for i, j, *numbers in edges[:MAX_EDGES]:
        table.add_row(f"{i}–{j}", *(shown_number(value, 3) for value in numbers))
    rest = [f"… and {len(edges) - MAX_EDGES} more in summary.json"] if len(edges) > MAX_EDGES else []
    return [_title(f"{len(edges)} link{'' if len(edges) == 1 else 's'} at the end"), table, *rest]


def _radio(summary: dict[str, Any]) -> list[RenderableType]:
    """Losses of the contacts in use as links: the worst, and the total; empty if no beacon was lost."""
    used = {(i, j) for i, j, *_ in summary["edges"]}
    contacts = [row for row in summary["radio"] if (min(row[:2]), max(row[:2])) in used]
    if all(sent == decoded for _, _, sent, decoded, _, _ in contacts):
        return []
    worst = sorted(contacts, key=lambda row: row[3] / row[2])[:MAX_CONTACTS]
    table = _table(["receiver ← sender", "sent", "decoded", "lost", "true outage", "longest gap"])
    for receiver, sender, *numbers in worst:
        table.add_row(f"{receiver} ← {sender}", *_beacons(*numbers))
    sent, decoded = (sum(row[column] for row in contacts) for column in (2, 3))
    known = [row for row in contacts if row[4] is not None]
    outage = sum(row[2] * row[4] for row in known) / sum(row[2] for row in known) if known else None
    table.add_row("all", *_beacons(sent, decoded, outage, max(row[5] for row in contacts)), style="bold")
    return [_title(f"Beacons over these links: the worst {len(worst)} of {len(contacts)} directions"), table]


def _expectations(summary: dict[str, Any]) -> list[RenderableType]:
    """Expected and seen values; empty without expectations."""
    if not summary["expectations"]:
        return []
    table = Table(box=None)
    for heading in ("expected", "to be", "seen", ""):
        table.add_column(heading)
    for expectation in summary["expectations"]:
        table.add_row(
            cell(expectation["of"]),
            cell(expectation["expected"]),
            cell(seen(expectation["seen"])),
            verdict(expectation),
        )
    return [_title("Expectations of the scenario"), table]


def _title(text: str) -> Text:
    return Text(text, style="italic")


def _table(headings: Iterable[str]) -> Table:
    table = Table(box=None)
    for heading in headings:
        table.add_column(cell(heading), justify="right")
    return table


def _beacons(sent: int, decoded: int, outage: float | None, longest_gap: int) -> list[str]:
    lost = percent(1.0 - decoded / sent)
    return [f"{sent:,}", f"{decoded:,}", lost, UNKNOWN if outage is None else percent(outage), f"{longest_gap:,}"]
