"""The panels beside the map, each a function from numbers to lines of styled text."""

import math
from functools import lru_cache

import numpy as np

from console.dashboard.canvas import Line
from console.measures import belief
from console.measures.team import SERIES, labels, series
from console.terminal.formatting import UNKNOWN, length, number, styled
from fes.arrays.types import Floats, Ints
from fes.protocol.report import Report
from world.metrics import graphs

MAX_SPECTRUM = 250
"""Maximum number of robots for which the algebraic connectivity is computed; beyond, it would delay the display."""

_LABEL = max(map(len, [*SERIES.values(), *belief.SERIES]))
_VALUE = 8
_AXIS = 8
_DECADES = 8  # maximum span of a log scale
_BARS = " ▁▂▃▄▅▆▇█"


def connectivity(report: Report) -> list[Line]:
    """Connectivity of the links and of the disk graph, and the robots that are not alive."""
    sizes, lambda_2 = _spectrum(len(report.alive), report.a.tobytes(), report.b.tobytes())
    state = styled("connected", "green")
    if len(sizes) != 1:
        largest = ", ".join(map(str, sizes[:3])) + (", …" if len(sizes) > 3 else "")
        state = styled(f"{len(sizes):,} components ({largest})", "yellow")
    algebraic = styled("" if lambda_2 is None else f"  λ₂ {lambda_2:.3g}")
    disk = styled("connected", "green") if report.disk_connected else styled("not connected", "yellow")
    graph = "heard       " if report.is_of_robots else "disk graph  "
    lines = [[styled("links       ", "dim"), state, algebraic], [styled(graph, "dim"), disk]]
    dead = np.flatnonzero(report.alive != 1).tolist()
    if dead:
        lines.append([styled("not alive   ", "dim"), styled(", ".join(map(str, dead[:40])), "bold red")])
    return lines


def convergence(report: Report, history: Floats, changes: Ints, width: int, rows: int) -> list[Line]:
    """A sparkline per row of `history` [3, k] [m] on a log scale, `rows` high.

    k is `sparkline_width`; `changes` are the columns in which the channel changed.
    """
    lines: list[Line] = []
    for values, label, latest in zip(history, labels(report), series(report).tolist(), strict=True):
        now = f"{length(latest):>{_VALUE}}"
        low, high = log_range(values)
        bars = [_marked(bar, changes) for bar in bar_rows(values, low, high, rows)]
        if rows == 1:
            lines.append([styled(f"{label:<{_LABEL}} ", "dim"), *bars[0], styled(now)])
            continue
        lines.append([styled(f"{label:<{max(0, width - _VALUE)}}", "dim"), styled(now)])
        axis = [length(10.0**high), *[""] * (rows - 2), _power(low)]
        for mark, bar in zip(axis, bars, strict=True):
            lines.append([styled(f"{mark:>{_AXIS - 1}} ", "dim"), *bar])
    return lines


def tracking(report: Report, width: int) -> Line:
    """Error of the mean estimate, and time until it stays within 1 m of r*, in the words that fit.

    Of real robots, whose r* is unknown, the mean estimate itself.
    """
    if report.is_of_robots:
        estimate = length(belief.mean_estimate(report))
        return [styled(f"{'mean estimate':<{_LABEL}} ", "dim"), styled(estimate)]
    error = report.mean_estimate_error
    passed = number(report.tick * report.dt - report.changed_at, ",.1f")
    if math.isfinite(report.tracking_time):
        took = f"{report.tracking_time:,.1f} s"
        words = [f"within 1 m of r* after {took}", f"within 1 m after {took}", f"< 1 m after {took}"]
    elif abs(error) < 1.0:
        words = [f"within 1 m of r*, not held yet, {passed} s so far", f"not held yet, {passed} s"]
    else:
        words = [f"not within 1 m of r* yet, {passed} s so far", f"not within 1 m, {passed} s"]
    shown_error, label = (
        f"{number(error, '+,.2f')} m" if math.isfinite(error) else UNKNOWN,
        f"{'mean estimate':<{_LABEL}} ",
    )
    shown = next((text for text in words if len(label) + len(shown_error) + 2 + len(text) <= width), "")
    return [styled(label, "dim"), styled(shown_error), styled(f", {shown}" if shown else "")]


def sparkline_width(width: int, rows: int) -> int:
    """Columns of a sparkline in a panel of `width`."""
    return max(1, width - (_LABEL + 1 + _VALUE if rows == 1 else _AXIS))


def log_range(values: Floats) -> tuple[float, float]:
    """Range of the common logarithms of the positive `values` [k]: from a full decade to the largest.

    >>> log_range(np.array([0.02, math.nan, 0.0, 100.0]))
    (-2.0, 2.0)
    """
    positive = values[np.isfinite(values) & (values > 0.0)]
    if len(positive) == 0:
        return -1.0, 0.0
    low, high = math.floor(math.log10(positive.min())), math.log10(positive.max())
    return float(max(low, math.floor(high) - _DECADES) if low < high else low - 1), high


def bar_rows(values: Floats, low: float, high: float, rows: int) -> list[str]:
    """Bars of `values` [k] from 10^low to 10^high, upper row first; a blank for NaN.

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


def _marked(bar: str, changes: Ints) -> Line:
    """A row of bars with marks in the columns of `changes`, unless these would hide the bars."""
    line, first = [], 0
    for column in changes.tolist() if len(changes) <= len(bar) // 4 else []:
        line += [styled(bar[first:column], "cyan"), styled("│", "yellow")]
        first = column + 1
    return [*line, styled(bar[first:], "cyan")]


def _power(exponent: float) -> str:
    return length(10.0**exponent).replace(".00", "").replace(".0", "")


@lru_cache(maxsize=8)
def _spectrum(n: int, a: bytes, b: bytes) -> tuple[list[int], float | None]:
    """Sizes of the components of the links, largest first, and lambda_2; cached, because links rarely change."""
    ends = np.frombuffer(a, dtype=np.int64), np.frombuffer(b, dtype=np.int64)
    is_known = (np.minimum(*ends) >= 0) & (np.maximum(*ends) < n)
    lower, higher = ends[0][is_known], ends[1][is_known]
    sizes = np.unique(graphs.components(n, lower, higher), return_counts=True)[1]
    lambda_2: float | None = 0.0  # exact where the graph is not connected
    if len(sizes) == 1:
        lambda_2 = graphs.algebraic_connectivity(n, lower, higher) if n <= MAX_SPECTRUM else None
    return sorted(sizes.tolist(), reverse=True), lambda_2
