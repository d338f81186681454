"""The dashboard's table of the links in use: separations, estimates and losses."""

import numpy as np

from console.dashboard.canvas import Line
from console.dashboard.panels.map_panel import OUTAGE_STYLES
from console.measures import reception
from console.measures.links import counted, errors, loss, outage_class
from console.terminal.formatting import count, number, percent, styled
from fes.arrays.types import Ints
from fes.protocol.report import Report

# Heading, width, and rank: the lowest is hidden first
_ORACLE = (
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
    ("outage", 6, 0),  # 1 minus the true reception
    ("decoded", 7, 4),
    ("learnt true", 11, 5),
    ("sent", 5, 2),
    ("gap", 5, 3),
)
_OF_ROBOTS = (
    ("separation", 10, 7),
    ("error", 7, 5),
    ("estimates", 13, 6),
    ("lost", 6, 4),
    ("sent", 5, 2),
)
_OF_MEASURING_ROBOTS = (*_OF_ROBOTS[:3], ("learnt", 6, 3), *_OF_ROBOTS[3:])
_NEEDED = 4  # the panel is made wide enough for columns of this rank and above


def links(report: Report, width: int, height: int) -> list[Line]:
    """The links in use that fit, worst separation first."""
    if len(report.a) == 0:
        return [[styled("no links", "dim")]]
    first = _first_column(report)
    columns, gap = _fit(report, width - first)
    heading = "link".ljust(first) + "".join(f"{name:>{gap + size}}" for name, size, _ in columns)
    order, error, lost = _worst_first(report), errors(report), loss(report)
    rows = len(order) if len(order) < height else max(0, height - 2)
    lines = [[styled(heading, "dim")]]
    for index in order[:rows].tolist():
        style = OUTAGE_STYLES[int(outage_class(lost[index : index + 1])[0])]
        line = [styled(_link(report, index).ljust(first))]
        for name, size, _ in columns:
            colored = style if name in ("outage", "learnt true", "lost") else ""
            text = number(error[index], "+.2f") if name == "error" else _cell(report, index, name)
            line.append(styled(f"{text:>{gap + size}}", colored))
        lines.append(line)
    if rows < len(order):
        lines.append([styled(f"… and {len(order) - rows:,} more", "dim")])
    return lines


def needed_width(report: Report) -> int:
    """Width of the table with its important columns, one cell apart."""
    return _first_column(report) + sum(size + 1 for _, size, rank in _columns(report) if rank >= _NEEDED)


def full_width(report: Report) -> int:
    """Width of the table with every column, two cells apart."""
    return _first_column(report) + sum(size + 2 for _, size, _ in _columns(report))


def _columns(report: Report) -> tuple[tuple[str, int, int], ...]:
    if report.is_of_robots:
        return _OF_MEASURING_ROBOTS if reception.is_measured(report) else _OF_ROBOTS
    return _MEASURED if reception.is_measured(report) else _ORACLE


def _first_column(report: Report) -> int:
    return max(len("link"), len(f"{report.a.max(initial=0)}–{report.b.max(initial=0)}"))


def _link(report: Report, index: int) -> str:
    return f"{report.a[index]}–{report.b[index]}"


def _fit(report: Report, width: int) -> tuple[list[tuple[str, int, int]], int]:
    """The columns that fit in `width`, and the gap before each."""
    columns = list(_columns(report))
    while len(columns) > 1 and sum(size + 1 for _, size, _ in columns) > width:
        columns.remove(min(columns, key=lambda column: column[2]))
    return columns, max(1, min(3, (width - sum(size for _, size, _ in columns)) // len(columns)))


def _worst_first(report: Report) -> Ints:
    """Order of the links by |error|, rounded as shown, so that rows that look equal keep their order."""
    with np.errstate(all="ignore"):
        error = np.round(np.abs(errors(report)), 2)
    order: Ints = np.lexsort((report.b, report.a, -np.where(np.isfinite(error), error, -1.0)))
    return order


def _cell(report: Report, index: int, column: str) -> str:
    separation = float(report.separation[index])
    match column:
        case "separation":
            return number(separation, ".2f")
        case "estimates":
            return f"{number(report.estimate_ab[index], '.2f'):>6} {number(report.estimate_ba[index], '.2f'):>6}"
        case "outage":
            return percent(float(report.outage[index]))
        case "lost":
            return percent(float(loss(report)[index]))
        case "learnt":
            return percent(float(report.learnt_reception[index]))
        case "learnt true":
            return (
                f"{percent(float(report.learnt_reception[index])):>5} {percent(1.0 - float(report.outage[index])):>5}"
            )
        case "sent":
            return count(float(report.sent[index]))
        case "gap":
            return count(float(report.longest_gap[index]))
        case _:
            return percent(float(counted(report)[index]))
