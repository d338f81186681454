"""The summary as a person reads it."""

from collections.abc import Iterable
from typing import Any

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from console.text import UNKNOWN, percent
from world.summary import links_lost

_TIMES = {
    "disagreement_1m": "disagreement < 1 m",
    "estimate_1m": "estimate error < 1 m",
    "estimate_0_1m": "estimate error < 0.1 m",
    "separation_1m": "separation error < 1 m",
    "separation_0_1m": "separation error < 0.1 m",
}

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
"""Columns: the key of a row of the summary's tracking, heading and format."""


def render(summary: dict[str, Any]) -> RenderableType:
    """The summary of a run as tables."""
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="bold")
    facts.add_column(overflow="fold")
    for name, value in _facts(summary):
        facts.add_row(name, value)
    digest = Text.assemble(("digest", "bold"), f" {summary['digest']}")
    tables = [*_tracking(summary["tracking"]), *_edges(summary["edges"]), *_radio(summary)]
    return Group(facts, digest, *tables, *_expectations(summary))


def _tracking(rows: list[dict[str, Any]]) -> list[RenderableType]:
    """How the mean estimate followed r*; columns that have no number yet are left out."""
    columns = [column for column in _TRACKING if any(row[column[0]] is not None for row in rows)]
    table = _table([heading for _, heading, _ in columns])
    for row in rows:
        table.add_row(*(UNKNOWN if row[key] is None else form.format(row[key]) for key, _, form in columns))
    return [*_title("The mean estimate, in m, from the start and from each change of the channel"), table]


def _edges(edges: list[list[Any]]) -> list[RenderableType]:
    table = _table(["link", "separation [m]", "estimate [m]", "estimate back [m]"])
    for i, j, *numbers in edges[:MAX_EDGES]:
        table.add_row(f"{i}–{j}", *(_meters(value, 3) for value in numbers))
    rest = [f"… and {len(edges) - MAX_EDGES} more in summary.json"] if len(edges) > MAX_EDGES else []
    return [*_title(f"{len(edges)} link{'' if len(edges) == 1 else 's'} at the end"), table, *rest]


def _radio(summary: dict[str, Any]) -> list[RenderableType]:
    """What the contacts in use as links lost: those that lost most, and all together; none if nothing was lost."""
    used = {(i, j) for i, j, *_ in summary["edges"]}
    contacts = [row for row in summary["radio"] if (min(row[:2]), max(row[:2])) in used]
    if all(sent == decoded for _, _, sent, decoded, _, _ in contacts):
        return []
    worst = sorted(contacts, key=lambda row: row[3] / row[2])[:MAX_CONTACTS]
    table = _table(["receiver ← sender", "sent", "decoded", "lost", "true outage", "longest gap"])
    for receiver, sender, *numbers in worst:
        table.add_row(f"{receiver} ← {sender}", *_beacons(*numbers))
    sent, decoded = (sum(row[column] for row in contacts) for column in (2, 3))
    outage = sum(row[2] * row[4] for row in contacts) / sent
    table.add_row("all", *_beacons(sent, decoded, outage, max(row[5] for row in contacts)), style="bold")
    return [*_title(f"Beacons over these links: the worst {len(worst)} of {len(contacts)} ways"), table]


def _expectations(summary: dict[str, Any]) -> list[RenderableType]:
    """What was expected and seen; nothing if nothing was."""
    if not summary["expectations"]:
        return []
    table = Table(box=None)
    for heading in ("expected", "to be", "seen", ""):
        table.add_column(heading)
    for one in summary["expectations"]:
        seen = f"{one['seen']:.6g}" if isinstance(one["seen"], float) else str(one["seen"])
        mark = Text("holds", style="green") if one["holds"] else Text("does not hold", style="bold red")
        table.add_row(escape(one["of"]), escape(one["expected"]), escape(seen), mark)
    return [*_title("What the scenario expects"), table]


def _title(text: str) -> list[RenderableType]:
    return ["", Text(text, style="italic")]


def _table(headings: Iterable[str]) -> Table:
    table = Table(box=None)
    for heading in headings:
        table.add_column(escape(heading), justify="right")
    return table


def _beacons(sent: int, decoded: int, outage: float, longest_gap: int) -> list[str]:
    return [f"{sent:,}", f"{decoded:,}", percent(1.0 - decoded / sent), percent(outage), f"{longest_gap:,}"]


def _facts(summary: dict[str, Any]) -> list[tuple[str, str]]:
    sent = summary["beacons_sent"]
    rate = f"{summary['ticks_per_s']:.0f} ticks/s, {summary['real_time_factor']:.1f}× real time"
    connectivity = summary["algebraic_connectivity"]
    facts = [
        (
            "run",
            f"{summary['scenario']}, {summary['robots']} robots, seed {summary['seed']}, {summary['backend']}",
        ),
        ("time", f"{summary['simulated_s']:g} s simulated in {summary['wall_s']:.1f} s ({rate})"),
        ("optimal separation", _meters(summary["optimal_separation"], 4) + " m"),
        ("largest separation error", _meters(summary["separation_error_max"], 4) + " m"),
        ("largest estimate error", _meters(summary["estimate_error_max"], 4) + " m"),
        ("disagreement", _meters(summary["disagreement"], 6) + " m"),
        ("disk graph connected", "always" if summary["disk_connected_always"] else "not always"),
        ("links connected", "always" if summary["links_connected_always"] else "not always"),
        ("algebraic connectivity", "not computed" if connectivity is None else f"{connectivity:.4f}"),
        ("beacons decoded", f"{summary['beacons_decoded']} of {sent}"),
    ]
    if summary["links_lost_at"] is not None:
        facts.append(("links", links_lost(summary["links_lost_at"])))
    kept = summary["deadlines"]
    if kept is not None:
        facts.append(("deadlines missed", _deadlines(kept)))
    facts += [
        (label, "never" if summary["time_to"][name] is None else f"at {summary['time_to'][name]:.2f} s, to hold")
        for name, label in _TIMES.items()
    ]
    return facts


def _deadlines(kept: dict[str, Any]) -> str:
    """How the robots kept the pace of the live clock, and which one did worst."""
    missed = kept["missed"]
    share = "none due" if kept["missed_share"] is None else f"{kept['missed_share']:.3%}"
    worst = max(range(len(missed)), key=missed.__getitem__)
    of_worst = f" (robot {worst}: {missed[worst]:,})" if missed[worst] else ""
    return (
        f"{sum(missed):,}, {share}{of_worst}; {sum(kept['late']):,} commands late, "
        f"{sum(kept['stopped']):,} ticks without one; the world slipped by {kept['slipped_s']:.3f} s"
    )


def _meters(value: float | None, digits: int) -> str:
    return UNKNOWN if value is None else f"{value:.{digits}f}"
