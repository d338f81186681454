"""The panels beside the map: each a function from numbers to lines of styled text."""

import math
from functools import lru_cache

import numpy as np

from console.canvas import Line
from console.teammap import OUTAGE_STYLES, outage_class
from console.text import length, number, styled
from fes.arrays import Floats, Ints
from fes.report import Report
from world import graphs

MAX_SPECTRUM = 250
"""Up to this many robots the algebraic connectivity is computed: for more it would hold up the display."""

SERIES = {
    "disagreement": "disagreement",
    "estimate_error_max": "estimate error",
    "separation_error_max": "separation error",
}
"""What is plotted: field of a Report, and its label."""

_LABEL = max(map(len, SERIES.values()))
_VALUE = 8
_AXIS = 8
_DECADES = 8  # a log scale goes at most so far below its largest value
_BARS = " ▁▂▃▄▅▆▇█"

# Heading, width, and rank when there is no room: the lowest goes first
_COLUMNS = (
    ("separation", 10, 5),
    ("error", 7, 1),
    ("estimates", 13, 4),
    ("outage", 6, 3),
    ("decoded", 7, 2),
)


def links(report: Report, width: int, height: int) -> list[Line]:
    """The links in use, worst separation first, as many as fit."""
    if len(report.a) == 0:
        return [[styled("no links", "dim")]]
    first = _first_column(report)
    columns, gap = _fit(width - first)
    heading = "link".ljust(first) + "".join(f"{name:>{gap + size}}" for name, size, _ in columns)
    order = _worst_first(report)
    rows = len(order) if len(order) < height else max(0, height - 2)
    lines = [[styled(heading, "dim")]]
    for at in order[:rows].tolist():
        style = OUTAGE_STYLES[int(outage_class(report.outage[at : at + 1])[0])]
        line = [styled(_link(report, at).ljust(first))]
        for name, size, _ in columns:
            line.append(styled(f"{_cell(report, at, name):>{gap + size}}", style if name == "outage" else ""))
        lines.append(line)
    if rows < len(order):
        lines.append([styled(f"… and {len(order) - rows:,} more", "dim")])
    return lines


def links_width(report: Report) -> int:
    """Width of the links with all that matters in columns one cell apart."""
    return _first_column(report) + sum(size + 1 for name, size, _ in _COLUMNS if name != "error")


def connectivity(report: Report) -> list[Line]:
    """Whether the links, and the robots in range, hold the team together."""
    sizes, lambda_2 = _spectrum(len(report.alive), report.a.tobytes(), report.b.tobytes())
    state = styled("connected", "green")
    if len(sizes) != 1:
        largest = ", ".join(map(str, sizes[:3])) + (", …" if len(sizes) > 3 else "")
        state = styled(f"{len(sizes):,} components ({largest})", "yellow")
    algebraic = styled("" if lambda_2 is None else f"  λ₂ {lambda_2:.3g}")
    disk = styled("connected", "green") if report.disk_connected else styled("not connected", "yellow")
    lines = [[styled("links       ", "dim"), state, algebraic], [styled("disk graph  ", "dim"), disk]]
    dead = np.flatnonzero(report.alive != 1).tolist()
    if dead:
        lines.append([styled("not alive   ", "dim"), styled(", ".join(map(str, dead[:40])), "bold red")])
    return lines


def convergence(report: Report, series: Floats, width: int, rows: int) -> list[Line]:
    """A sparkline each of `series` [3, k] [m] on a log scale, `rows` high, under its label if that is > 1.

    `series` has as many columns as `sparkline_width` says.
    """
    lines: list[Line] = []
    for values, (field, label) in zip(series, SERIES.items(), strict=True):
        now = f"{length(getattr(report, field)):>{_VALUE}}"
        low, high = log_range(values)
        bars = bar_rows(values, low, high, rows)
        if rows == 1:
            lines.append([styled(f"{label:<{_LABEL}} ", "dim"), styled(bars[0], "cyan"), styled(now)])
            continue
        lines.append([styled(f"{label:<{max(0, width - _VALUE)}}", "dim"), styled(now)])
        axis = [length(10.0**high), *[""] * (rows - 2), _power(low)]
        for mark, bar in zip(axis, bars, strict=True):
            lines.append([styled(f"{mark:>{_AXIS - 1}} ", "dim"), styled(bar, "cyan")])
    return lines


def sparkline_width(width: int, rows: int) -> int:
    """Columns of a sparkline in a panel of `width`."""
    return max(1, width - (_LABEL + 1 + _VALUE if rows == 1 else _AXIS))


def log_range(values: Floats) -> tuple[float, float]:
    """Common logarithms between which to plot the positive `values` [k]: from a whole decade to the largest.

    >>> log_range(np.array([0.02, math.nan, 0.0, 100.0]))
    (-2.0, 2.0)
    """
    positive = values[np.isfinite(values) & (values > 0.0)]
    if len(positive) == 0:
        return -1.0, 0.0
    low, high = math.floor(math.log10(positive.min())), math.log10(positive.max())
    return float(max(low, math.floor(high) - _DECADES) if low < high else low - 1), high


def bar_rows(values: Floats, low: float, high: float, rows: int) -> list[str]:
    """Bars of `values` [k] from 10^low to 10^high, upper row first; a blank where there is no number.

    >>> bar_rows(np.array([100.0, 10.0, 1.0, math.nan]), 0.0, 2.0, 2)
    ['█▁  ', '██▁ ']
    """
    known = np.isfinite(values)
    positive = np.where(known & (values > 0.0), values, 10.0**low)
    part = np.clip((np.log10(positive) - low) / (high - low), 0.0, 1.0)
    steps = len(_BARS) - 1
    level = np.where(known, 1 + np.rint(part * (rows * steps - 1)), 0).astype(np.int64)
    filled = [np.clip(level - row * steps, 0, steps).tolist() for row in reversed(range(rows))]
    return ["".join(_BARS[step] for step in row) for row in filled]


def _power(exponent: float) -> str:
    return length(10.0**exponent).replace(".00", "").replace(".0", "")


def _first_column(report: Report) -> int:
    return max(len("link"), len(f"{report.a.max(initial=0)}–{report.b.max(initial=0)}"))


def _link(report: Report, at: int) -> str:
    return f"{report.a[at]}–{report.b[at]}"


def _fit(width: int) -> tuple[list[tuple[str, int, int]], int]:
    """The columns that fit in `width`, and the gap before each."""
    columns = list(_COLUMNS)
    while len(columns) > 1 and sum(size + 1 for _, size, _ in columns) > width:
        columns.remove(min(columns, key=lambda column: column[2]))
    return columns, max(1, min(3, (width - sum(size for _, size, _ in columns)) // len(columns)))


def _worst_first(report: Report) -> Ints:
    """Links by |separation - r*|, rounded as it is shown, so that rows that look equal keep their order."""
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
            return _percent(float(report.outage[at]))
        case _:
            return _percent(float(report.decoded[at] / report.sent[at]) if report.sent[at] else math.nan)


def _percent(part: float) -> str:
    return number(part, ".1%")


@lru_cache(maxsize=8)
def _spectrum(n: int, a: bytes, b: bytes) -> tuple[list[int], float | None]:
    """Sizes of the components of the links, largest first, and lambda_2; kept, for links change seldom."""
    ends = np.frombuffer(a, dtype=np.int64), np.frombuffer(b, dtype=np.int64)
    fine = (np.minimum(*ends) >= 0) & (np.maximum(*ends) < n)
    lower, higher = ends[0][fine], ends[1][fine]
    sizes = np.unique(graphs.components(n, lower, higher), return_counts=True)[1]
    lambda_2: float | None = 0.0  # not the 1e-16 of rounding where it is not connected
    if len(sizes) == 1:
        lambda_2 = graphs.algebraic_connectivity(n, lower, higher) if n <= MAX_SPECTRUM else None
    return sorted(sizes.tolist(), reverse=True), lambda_2
