"""The summary for a terminal: the most important numbers are last, so that they remain visible."""

from collections.abc import Iterable
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from console.terminal.formatting import UNKNOWN, percent
from console.terminal.printing import cell
from world.metrics.summary import links_lost

BELOW = 11
"""Lines of a summary at 80 columns, with the line of the run directory; without deadlines, expectations, metrics."""

MAX_EDGES = 30
MAX_CONTACTS = 5
MAX_EXPECTED = 4
"""Maximum number of expectations shown; those not met are first."""

MAX_NUMBERS = 12
"""Maximum number of numbers shown for a metric of the scenario."""

LONGEST_NAME = 40

FIXED = 1e9
"""Numbers from this on are shown with an exponent."""

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


def render(summary: dict[str, Any], verbose: bool = False) -> RenderableType:
    """The summary of a run; with `verbose`, tables of its tracking, links, beacons and expectations precede it."""
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="bold", no_wrap=True)
    facts.add_column(overflow="fold")
    expected = [] if verbose else _expected(summary)
    arithmetic = _arithmetic(summary["arithmetic"]) if verbose else []
    rows = [*_conditions(summary), *expected, *_metrics(summary["metrics"]), *arithmetic, *_headline(summary)]
    for name, value in rows:
        facts.add_row(cell(name), value if isinstance(value, Text) else cell(value))
    digest = Text.assemble(("digest", "bold"), cell(f"  {summary['digest']}"), no_wrap=True, overflow="ignore")
    return Group(*(_tables(summary) if verbose else []), facts, digest)


def _tables(summary: dict[str, Any]) -> list[RenderableType]:
    tables = [_tracking(summary["tracking"]), _edges(summary["edges"]), _radio(summary), _expectations(summary)]
    return [part for table in tables if table for part in (*table, "")]


def _conditions(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Rows about connectivity, beacons and deadlines."""
    disk = "always" if summary["disk_connected_always"] else "not always"
    links = "always" if summary["links_connected_always"] else "not always"
    connectivity = summary["algebraic_connectivity"]
    lambda_2 = "not computed" if connectivity is None else f"{connectivity:.4f}"
    sent, decoded = summary["beacons_sent"], summary["beacons_decoded"]
    share = f" ({percent(decoded / sent)})" if sent else ""
    rows = [
        ("connected", f"disk graph {disk}, links {links}, λ₂ {lambda_2}"),
        ("beacons decoded", f"{decoded:,} of {sent:,}{share}"),
    ]
    if summary["links_lost_at"] is not None:
        rows.append(("links", links_lost(summary["links_lost_at"])))
    if summary["deadlines"] is not None:
        rows.append(("deadlines missed", _deadlines(summary["deadlines"])))
    return rows


def _headline(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Rows about the result."""
    name = summary["scenario"]
    name = name if len(name) <= LONGEST_NAME else f"{name[:LONGEST_NAME]}…"
    rate = f"{_number(summary['ticks_per_s'], 0)} ticks/s, {_number(summary['real_time_factor'], 1)}× real time"
    return [
        *_team(summary),
        ("run", f"{name}, {summary['robots']} robots, seed {summary['seed']}, {summary['backend']}"),
        ("disagreement", f"{_meters(summary['disagreement'], 6)}{_since(summary, 'disagreement')}"),
        ("estimate error", f"largest {_meters(summary['estimate_error_max'], 4)}{_since(summary, 'estimate')}"),
        ("separation error", f"largest {_meters(summary['separation_error_max'], 4)}{_since(summary, 'separation')}"),
        ("best length" if "team_index" in summary else "r*", _meters(summary["optimal_separation"], 4)),
        ("time", f"{summary['simulated_s']:g} s simulated in {_number(summary['wall_s'], 1)} s ({rate})"),
    ]


def _team(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Row about the team index, if it was computed."""
    if "team_index" not in summary:
        return []
    value, target = summary["team_index"], summary["team_index_target"]
    share = f" ({percent(value / target)})" if value is not None and target else ""
    times = [(level, summary[f"team_index_{level}_at"]) for level in (95, 99)]
    reached = ", ".join(
        f"never {level}%" if since is None else f"{level}% from {since:.2f} s on" for level, since in times
    )
    cutting = summary["cutting_robots"]
    lost = "the links are cut" if cutting is None else f"{cutting or 'no'} cutting robot{'' if cutting == 1 else 's'}"
    index = f"{_number(value, 4)} of {_number(target, 4)}{share}, {reached}" if share else _number(value, 4)
    return [("team index", f"{index}; {lost}")]


def _arithmetic(arithmetic: dict[str, str]) -> list[tuple[str, str]]:
    """Row about the implementation of the elementary functions."""
    return [("arithmetic", f"fingerprint {arithmetic['fingerprint']}, with numpy {arithmetic['numpy']}")]


def _since(summary: dict[str, Any], what: str) -> str:
    """Times from which an error stayed below each level."""
    text = ""
    for level, label in (("1m", "1 m"), ("0_1m", "0.1 m")):
        if f"{what}_{level}" in summary["time_to"]:
            time = summary["time_to"][f"{what}_{level}"]
            text += f", < {label} " + ("never" if time is None else f"from {time:.2f} s on")
    return text


def _expected(summary: dict[str, Any]) -> list[tuple[str, Text]]:
    """Rows of the expectations; those not met are first."""
    verdicts = sorted(summary["expectations"], key=lambda expectation: bool(expectation["holds"]))
    rows = [
        ("expected", Text.assemble(cell(_outcome(expectation)), _verdict(expectation)))
        for expectation in verdicts[:MAX_EXPECTED]
    ]
    if len(verdicts) > MAX_EXPECTED:
        unmet = sum(not expectation["holds"] for expectation in verdicts)
        rows.append(("", cell(f"{len(verdicts)} expectations, {unmet} not met")))
    for _, line in rows:
        line.no_wrap, line.overflow = True, "ellipsis"
    return rows


def _metrics(metrics: dict[str, dict[str, float | None]]) -> list[tuple[str, str]]:
    """One row per metric of the scenario, with its numbers."""
    rows = []
    for number, (name, numbers) in enumerate(metrics.items()):
        shown = [f"{key} {_seen(value)}" for key, value in list(numbers.items())[:MAX_NUMBERS]]
        rest = f", and {len(numbers) - MAX_NUMBERS} more in summary.json" if len(numbers) > MAX_NUMBERS else ""
        rows.append(("" if number else "metrics", f"{name}: {', '.join(shown) or 'no numbers'}{rest}"))
    return rows


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
        table.add_row(f"{i}–{j}", *(_number(value, 3) for value in numbers))
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
            cell(_seen(expectation["seen"])),
            _verdict(expectation),
        )
    return [_title("Expectations of the scenario"), table]


def _outcome(expectation: dict[str, Any]) -> str:
    return f"{expectation['of']} {expectation['expected']}: {_seen(expectation['seen'])}, "


def _verdict(expectation: dict[str, Any]) -> Text:
    return Text("holds", style="green") if expectation["holds"] else Text("does not hold", style="bold red")


def _seen(value: Any) -> str:
    if value is None:
        return UNKNOWN
    return f"{value:.6g}" if isinstance(value, float) else str(value)


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


def _deadlines(deadlines: dict[str, Any]) -> str:
    """Missed deadlines of the live clock, and the robot with most."""
    missed = deadlines["missed"]
    share = "none due" if deadlines["missed_share"] is None else f"{deadlines['missed_share']:.3%}"
    worst = max(range(len(missed)), key=missed.__getitem__)
    slipped = _number(deadlines["slipped_s"], 3)
    of_worst = f" (robot {worst}: {missed[worst]:,})" if missed[worst] else ""
    return (
        f"{sum(missed):,}, {share}{of_worst}; {sum(deadlines['late']):,} commands late, "
        f"{sum(deadlines['stopped']):,} ticks without a command; the world slipped by {slipped} s"
    )


def _meters(value: float | None, digits: int) -> str:
    return f"{_number(value, digits)} m"


def _number(value: float | None, digits: int) -> str:
    if value is None:
        return UNKNOWN
    return f"{value:.{digits}f}" if abs(value) < FIXED else f"{value:.6g}"
