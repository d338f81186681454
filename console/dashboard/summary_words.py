"""Numbers and verdicts of a summary in words."""

from typing import Any

from rich.text import Text

from console.terminal.formatting import UNKNOWN, percent
from world.metrics.summary import links_lost

FIXED = 1e9
"""Numbers from this on are shown with an exponent."""


def shown_number(value: float | None, digits: int) -> str:
    """A number with so many digits after the point; UNKNOWN for a missing one."""
    if value is None:
        return UNKNOWN
    return f"{value:.{digits}f}" if abs(value) < FIXED else f"{value:.6g}"


def meters(value: float | None, digits: int) -> str:
    """A length [m]."""
    return f"{shown_number(value, digits)} m"


def seen(value: Any) -> str:
    """The value of an expectation, or of a metric, at the end of a run."""
    if value is None:
        return UNKNOWN
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def verdict(expectation: dict[str, Any]) -> Text:
    """Whether an expectation holds."""
    return Text("holds", style="green") if expectation["holds"] else Text("does not hold", style="bold red")


def reached(summary: dict[str, Any], error: str) -> str:
    """Times at which an error reached each of its levels, as the glossary defines it."""
    words: list[str] = []
    for level, label in (("1m", "1 m"), ("0_1m", "0.1 m")):
        if f"{error}_{level}" in summary["time_to"]:
            time = summary["time_to"][f"{error}_{level}"]
            verb = "" if words and "not" not in words[-1] else "reached "
            words.append(f"{label} not reached" if time is None else f"{label} {verb}at {time:.2f} s")
    return "".join(f"{';' if number == 0 else ','} {word}" for number, word in enumerate(words))


def team_index(summary: dict[str, Any]) -> str:
    """The team index against its target, and the times from which it held shares of that to the end."""
    value, target = summary["team_index"], summary["team_index_target"]
    if value is None or not target:
        return shown_number(value, 4)
    times = [(level, summary[f"team_index_{level}_at"]) for level in (95, 99)]
    held = ", ".join(
        f"{level}% not held" if since is None else f"{level}% since {since:.2f} s" for level, since in times
    )
    return f"{shown_number(value, 4)} of {shown_number(target, 4)} ({percent(value / target)}); {held}"


def headline(summary: dict[str, Any]) -> Text:
    """The result in one line."""
    return Text.assemble((f"{summary['robots']:,} robots, {_result(summary)}", "bold"), *_expectations(summary))


def _result(summary: dict[str, Any]) -> str:
    links = len(summary["edges"])
    if summary["links_lost_at"] is not None:
        return f"no links: {links_lost(summary['links_lost_at'])}"
    if "team_index" in summary and summary["team_index"] is not None and summary["team_index_target"]:
        return f"team index at the end {percent(summary['team_index'] / summary['team_index_target'])} of its target"
    if not links:
        return "no links"
    optimal = meters(summary["optimal_separation"], 3)
    error = meters(summary["separation_error_max"], 4)
    return f"{links:,} link{'s' if links > 1 else ''} at the end within {error} of r* = {optimal}"


def _expectations(summary: dict[str, Any]) -> list[Text]:
    number = len(summary["expectations"])
    unmet = sum(not expectation["holds"] for expectation in summary["expectations"])
    if unmet:
        return [Text(f"; {unmet} of {number} expectations not met", style="bold red")]
    return [Text(f"; {number} expectation{'s' if number > 1 else ''} met", style="green")] if number else []
