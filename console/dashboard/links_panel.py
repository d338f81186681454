"""The dashboard's table of the links in use: where they are, what they lose, and what is believed of them."""

import numpy as np

from console.dashboard import reception_panel
from console.dashboard.canvas import Line
from console.dashboard.map_panel import OUTAGE_STYLES, outage_class
from console.terminal.formatting import count, number, percent, styled
from fes.arrays.types import Ints
from fes.protocol.report import Report

# Heading, width, and rank when there is no room: the lowest goes first
_TOLD = (
    ("separation", 10, 7),
    ("error", 7, 1),
    ("estimates", 13, 6),
    ("outage", 6, 5),
    ("decoded", 7, 4),
    ("sent", 5, 2),
    ("gap", 5, 3),
)
_MEASURED = (
    ("separation", 10, 7),
    ("error", 7, 1),
    ("estimates", 13, 6),
    ("outage", 6, 0),  # one less the true reception
    ("decoded", 7, 4),
    ("learnt true", 11, 5),
    ("sent", 5, 2),
    ("gap", 5, 3),
)
_NEEDED = 4  # rank from which a column matters so much that the panel is made wide enough for it


def links(report: Report, width: int, height: int) -> list[Line]:
    """The links in use, worst separation first, as many as fit."""
    if len(report.a) == 0:
        return [[styled("no links", "dim")]]
    first = _first_column(report)
    columns, gap = _fit(report, width - first)
    heading = "link".ljust(first) + "".join(f"{name:>{gap + size}}" for name, size, _ in columns)
    order = _worst_first(report)
    rows = len(order) if len(order) < height else max(0, height - 2)
    lines = [[styled(heading, "dim")]]
    for at in order[:rows].tolist():
        style = OUTAGE_STYLES[int(outage_class(report.outage[at : at + 1])[0])]
        line = [styled(_link(report, at).ljust(first))]
        for name, size, _ in columns:
            colored = style if name in ("outage", "learnt true") else ""
            line.append(styled(f"{_cell(report, at, name):>{gap + size}}", colored))
        lines.append(line)
    if rows < len(order):
        lines.append([styled(f"… and {len(order) - rows:,} more", "dim")])
    return lines


def needed_width(report: Report) -> int:
    """Width of the table with all that matters in columns one cell apart."""
    return _first_column(report) + sum(size + 1 for _, size, rank in _columns(report) if rank >= _NEEDED)


def full_width(report: Report) -> int:
    """Width of the table with every column, two cells apart."""
    return _first_column(report) + sum(size + 2 for _, size, _ in _columns(report))


def _columns(report: Report) -> tuple[tuple[str, int, int], ...]:
    return _MEASURED if reception_panel.is_measured(report) else _TOLD


def _first_column(report: Report) -> int:
    return max(len("link"), len(f"{report.a.max(initial=0)}–{report.b.max(initial=0)}"))


def _link(report: Report, at: int) -> str:
    return f"{report.a[at]}–{report.b[at]}"


def _fit(report: Report, width: int) -> tuple[list[tuple[str, int, int]], int]:
    """The columns that fit in `width`, and the gap before each."""
    columns = list(_columns(report))
    while len(columns) > 1 and sum(size + 1 for _, size, _ in columns) > width:
        columns.remove(min(columns, key=lambda column: column[2]))
    return columns, max(1, min(3, (width - sum(size for _, size, _ in columns)) // len(columns)))


def _worst_first(report: Report) -> Ints:
    """Links by |separation - r*|, rounded as it is shown, so that rows that look equal keep their order."""
    with np.errstate(all="ignore"):
        error = np.round(np.abs(report.separation - report.optimal_separation), 2)
    order: Ints = np.lexsort((report.b, report.a, -np.where(np.isfinite(error), error, -1.0)))
    return order


def _cell(report: Report, at: int, column: str) -> str:
    separation = float(report.separation[at])
    match column:
        case "separation":
            return number(separation, ".2f")
        case "error":
            return number(separation - report.optimal_separation, "+.2f")
        case "estimates":
            return f"{number(report.estimate_ab[at], '.2f'):>6} {number(report.estimate_ba[at], '.2f'):>6}"
        case "outage":
            return percent(float(report.outage[at]))
        case "learnt true":
            return f"{percent(float(report.learnt_reception[at])):>5} {percent(1.0 - float(report.outage[at])):>5}"
        case "sent":
            return count(float(report.sent[at]))
        case "gap":
            return count(float(report.longest_gap[at]))
        case _:
            return percent(float(reception_panel.counted(report)[at]))
