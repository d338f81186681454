"""The summary of a run for a terminal: at most MOST lines at 80 columns, the headline last; `--verbose` shows all."""

from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from console.dashboard.summary_tables import tables
from console.dashboard.summary_words import headline, meters, reached, seen, shown_number, team_index, verdict
from console.terminal.formatting import percent
from console.terminal.printing import cell
from world.config.scenario import Scenario
from world.metrics import graphs
from world.metrics.summary import links_lost

MOST = 20
"""Most lines of a summary at 80 columns, with the run directory and the headline, unless it is verbose."""

MAX_EXPECTED = 4
"""Maximum number of expectations shown; those not met are first."""

MAX_NUMBERS = 12
"""Maximum number of numbers shown for a metric of the scenario."""

LONGEST_NAME = 40

_ROOM = 62  # cells of a value at 80 columns
_FIXED_ROWS = 8  # of any run
_END = 3  # lines of digest, run directory and headline

Row = tuple[str, str | Text]


def render(summary: dict[str, Any], verbose: bool = False) -> RenderableType:
    """The summary without its headline; with `verbose`, tables precede it, and each row is whole."""
    before, after = _conditions(summary), _numbers(summary)
    if verbose:
        optional = [*_metrics(summary["metrics"]), *_arithmetic(summary["arithmetic"])]
    else:
        room = MOST - _END - sum(_height(value) for _, value in (*before, *after))
        expected, metrics = _share(len(summary["expectations"]), len(summary["metrics"]), room)
        optional = [*_expected(summary, expected), *_short_metrics(summary["metrics"], metrics)]
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="bold", no_wrap=True)
    facts.add_column(overflow="fold")
    for name, value in (*before, *optional, *after):
        facts.add_row(cell(name), value if isinstance(value, Text) else cell(value))
    digest = Text.assemble(("digest", "bold"), cell(f"  {summary['digest']}"), no_wrap=True, overflow="ignore")
    return Group(*(tables(summary) if verbose else []), facts, digest)


def last_line(summary: dict[str, Any]) -> RenderableType:
    """The headline, which is printed last so that it remains visible."""
    return headline(summary)


def below(scenario: Scenario) -> int:
    """Lines of the summary of a run of the scenario at 80 columns, if its links last."""
    rows = _FIXED_ROWS + 2 * scenario.has_team_index + 2 * (scenario.run.clock == "live")
    return rows + _END + sum(_share(len(scenario.expect), len(scenario.metric), MOST - _END - rows))


def _share(expected: int, metrics: int, room: int) -> tuple[int, int]:
    """Rows for the expectations and for the metrics; the last row counts the others."""
    expected = min(expected, MAX_EXPECTED + 1)
    if expected + metrics <= room:
        return expected, metrics
    fewest = min(expected, max(1, room // 2))
    of_metrics = min(metrics, max(0, room - fewest))
    return min(expected, max(0, room - of_metrics)), of_metrics


def _height(value: str | Text) -> int:
    return 1 if len(value) <= _ROOM else 2


def _conditions(summary: dict[str, Any]) -> list[Row]:
    """Rows about connectivity, beacons and deadlines."""
    disk = "always" if summary["disk_connected_always"] else "not always"
    links = "always" if summary["links_connected_always"] else "not always"
    sent, decoded = summary["beacons_sent"], summary["beacons_decoded"]
    share = f" ({percent(decoded / sent)})" if sent else ""
    rows: list[Row] = [
        ("connected", f"disk graph {disk}, links {links}, {_connectivity(summary)}"),
        ("beacons decoded", f"{decoded:,} of {sent:,}{share}"),
    ]
    if summary["links_lost_at"] is not None:
        rows.append(("links", links_lost(summary["links_lost_at"])))
    if summary["deadlines"] is not None:
        rows += _deadlines(summary["deadlines"])
    return rows


def _connectivity(summary: dict[str, Any]) -> str:
    """The algebraic connectivity; where an absent robot makes it 0, that of the robots with links."""
    value = summary["algebraic_connectivity"]
    if value is None:
        return "λ₂ not computed"
    linked, rows = np.unique(np.array([row[:2] for row in summary["edges"]], dtype=np.int64), return_inverse=True)
    if value > 0.0 or not 2 <= len(linked) < summary["robots"]:
        return f"λ₂ {value:.4f}"
    ends = rows.reshape(-1, 2)
    value = graphs.algebraic_connectivity(len(linked), ends[:, 0], ends[:, 1])
    return f"λ₂ {value:.4f} of {len(linked)} linked"


def _numbers(summary: dict[str, Any]) -> list[Row]:
    """Rows about the result."""
    name = summary["scenario"]
    name = name if len(name) <= LONGEST_NAME else f"{name[:LONGEST_NAME]}…"
    ticks, factor = shown_number(summary["ticks_per_s"], 0), shown_number(summary["real_time_factor"], 1)
    return [
        *_team(summary),
        ("run", f"{name}, {summary['robots']} robots, seed {summary['seed']}, {summary['backend']}"),
        ("disagreement", f"{meters(summary['disagreement'], 6)}{reached(summary, 'disagreement')}"),
        ("estimate error", f"largest {meters(summary['estimate_error_max'], 4)}{reached(summary, 'estimate')}"),
        ("separation error", f"largest {meters(summary['separation_error_max'], 4)}{reached(summary, 'separation')}"),
        ("best length" if "team_index" in summary else "r*", meters(summary["optimal_separation"], 4)),
        (
            "time",
            f"{summary['simulated_s']:g} s simulated in {shown_number(summary['wall_s'], 1)} s "
            f"({ticks} ticks/s, {factor}× real time)",
        ),
    ]


def _team(summary: dict[str, Any]) -> list[Row]:
    """Rows about the team index, if it was computed."""
    if "team_index" not in summary:
        return []
    cutting = summary["cutting_robots"]
    return [
        ("team index", team_index(summary)),
        ("cutting robots", "the links are cut" if cutting is None else f"{cutting or 'none'}"),
    ]


def _arithmetic(arithmetic: dict[str, str]) -> list[Row]:
    """Row about the implementation of the elementary functions."""
    return [("arithmetic", f"fingerprint {arithmetic['fingerprint']}, with numpy {arithmetic['numpy']}")]


def _expected(summary: dict[str, Any], rows: int) -> list[Row]:
    """At most `rows` rows of the expectations; those not met are first."""
    verdicts = sorted(summary["expectations"], key=lambda expectation: bool(expectation["holds"]))
    shown = rows if len(verdicts) <= rows else rows - 1
    lines: list[Row] = [
        ("expected", Text.assemble(cell(_outcome(expectation)), verdict(expectation)))
        for expectation in verdicts[: max(0, shown)]
    ]
    if len(verdicts) > rows > 0:
        unmet = sum(not expectation["holds"] for expectation in verdicts)
        lines.append(("", cell(f"{len(verdicts)} expectations, {unmet} not met")))
    for _, line in lines:
        if isinstance(line, Text):
            line.no_wrap, line.overflow = True, "ellipsis"
    return lines


def _outcome(expectation: dict[str, Any]) -> str:
    return f"{expectation['of']} {expectation['expected']}: {seen(expectation['seen'])}, "


def _short_metrics(metrics: dict[str, dict[str, float | None]], rows: int) -> list[Row]:
    """At most `rows` rows of one line each, with the numbers that fit."""
    shown = rows if len(metrics) <= rows else rows - 1
    lines = [_fitting(name, numbers) for name, numbers in list(metrics.items())[: max(0, shown)]]
    if len(metrics) > rows > 0:
        lines.append(f"{len(metrics) - len(lines)} more with --verbose")
    return [("" if number else "metrics", line) for number, line in enumerate(lines)]


def _fitting(name: str, numbers: dict[str, float | None]) -> str:
    """A metric with as many of its numbers as fit."""
    shown = [f"{key} {seen(value)}" for key, value in numbers.items()]
    for count in range(len(shown), 0, -1):
        rest = "" if count == len(shown) else f", and {len(shown) - count} more"
        if len(text := f"{name}: {', '.join(shown[:count])}{rest}") <= _ROOM:
            return text
    return f"{name}: {len(shown) or 'no'} numbers"


def _metrics(metrics: dict[str, dict[str, float | None]]) -> list[Row]:
    """One row per metric of the scenario, with its numbers."""
    rows: list[Row] = []
    for number, (name, numbers) in enumerate(metrics.items()):
        shown = [f"{key} {seen(value)}" for key, value in list(numbers.items())[:MAX_NUMBERS]]
        rest = f", and {len(numbers) - MAX_NUMBERS} more in summary.json" if len(numbers) > MAX_NUMBERS else ""
        rows.append(("" if number else "metrics", f"{name}: {', '.join(shown) or 'no numbers'}{rest}"))
    return rows


def _deadlines(deadlines: dict[str, Any]) -> list[Row]:
    """Missed deadlines of the live clock, the robot with most of them, and their effects."""
    missed = deadlines["missed"]
    share = "none due" if deadlines["missed_share"] is None else f"{deadlines['missed_share']:.3%}"
    worst = max(range(len(missed)), key=missed.__getitem__)
    of_worst = f" (robot {worst}: {missed[worst]:,})" if missed[worst] else ""
    late, stopped = sum(deadlines["late"]), sum(deadlines["stopped"])
    slipped = shown_number(deadlines["slipped_s"], 3)
    return [
        ("deadlines missed", f"{sum(missed):,}, {share}{of_worst}"),
        ("commands", f"{late:,} late, {stopped:,} ticks without one, world slipped {slipped} s"),
    ]
