"""Numbers and verdicts of a summary in words."""

from typing import Any

from rich.text import Text

from console.terminal.formatting import UNKNOWN, length, percent

LONGEST = 80
"""Cells of the headline."""

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
    """The verdict on an expectation."""
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
    """The result at the end of the run, in one line of at most LONGEST cells if its numbers allow it."""
    verdict = _expectations(summary)
    results = [f"{summary['robots']:,} robots, {result}" for result in _results(summary)]
    result = next((text for text in results if len(text) + len(verdict) <= LONGEST), results[-1])
    return Text.assemble((result, "bold"), verdict)


def _results(summary: dict[str, Any]) -> list[str]:
    """The result, and shorter forms of it."""
    value, target = summary.get("team_index"), summary.get("team_index_target")
    if value is not None and target:
        return [f"team index {percent(value / target)} of its target"]
    links, error, optimal = len(summary["edges"]), summary["separation_error_max"], summary["optimal_separation"]
    counted = f"{links:,} link{'' if links == 1 else 's'}" if links else "no links"
    if error is None or optimal is None:
        return [counted]
    within = f"{counted} within {length(error)} of r*"
    return [f"{within} = {length(optimal)}", within]


def _expectations(summary: dict[str, Any]) -> Text:
    number = len(summary["expectations"])
    unmet = sum(not expectation["holds"] for expectation in summary["expectations"])
    plural = "" if number == 1 else "s"
    if unmet:
        return Text(f"; {unmet} of {number} expectation{plural} not met", style="bold red")
    return Text(f"; {number} expectation{plural} met" if number else "", style="green")
