"""The summary as a person reads it."""

from typing import Any

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

_TIMES = {
    "disagreement_1m": "disagreement < 1 m",
    "estimate_1m": "estimate error < 1 m",
    "estimate_0_1m": "estimate error < 0.1 m",
    "separation_1m": "separation error < 1 m",
    "separation_0_1m": "separation error < 0.1 m",
}

MAX_EDGES = 30


def render(summary: dict[str, Any]) -> RenderableType:
    """The summary of a run as tables."""
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="bold")
    facts.add_column(overflow="fold")
    for name, value in _facts(summary):
        facts.add_row(name, value)
    count = len(summary["edges"])
    edges = Table(title=f"{count} link{'' if count == 1 else 's'} at the end", title_justify="left", box=None)
    for heading in ("link", "separation [m]", "estimate [m]", "estimate back [m]"):
        edges.add_column(escape(heading), justify="right")
    for i, j, *numbers in summary["edges"][:MAX_EDGES]:
        edges.add_row(f"{i}–{j}", *(_meters(value, 3) for value in numbers))
    rest = len(summary["edges"]) - MAX_EDGES
    digest = Text.assemble(("digest", "bold"), f" {summary['digest']}")
    return Group(facts, digest, "", edges, *([f"… and {rest} more in summary.json"] if rest > 0 else []))


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
    facts += [
        (label, "never" if summary["time_to"][name] is None else f"from {summary['time_to'][name]:.2f} s on")
        for name, label in _TIMES.items()
    ]
    return facts


def _meters(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
