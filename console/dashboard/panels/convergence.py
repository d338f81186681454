"""The panel of convergence: errors over time on a log scale, and the tracking of r*."""

import math

import numpy as np

from console.dashboard.canvas import Line
from console.measures import belief
from console.measures.team import SERIES, labels, series
from console.terminal.formatting import UNKNOWN, length, number, styled
from fes.arrays.types import Floats, Ints
from fes.protocol.report import Report

AWAITED = "known after a dither period"
"""Text for an error that is averaged over a dither period, before the end of the first one."""

_LABEL = max(map(len, [*SERIES.values(), *belief.SERIES]))
_VALUE = 8
_AXIS = 8
_DECADES = 8  # maximum span of a log scale
_BARS = " ▁▂▃▄▅▆▇█"


def convergence(report: Report, history: Floats, changes: Ints, width: int, rows: int) -> list[Line]:
    """A sparkline per row of `history` [3, k] [m] on a log scale, `rows` high.

    k is `sparkline_width`; `changes` are the columns in which the channel changed.
    """
    lines: list[Line] = []
    for values, label, latest in zip(history, labels(report), series(report).tolist(), strict=True):
        if label == SERIES["separation_error_max"] and is_awaited(report, history):
            lines.append([styled(f"{label:<{_LABEL}} {AWAITED}", "dim")])
            continue
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
    """Error of the mean estimate, and the time after which it reached r*, in the words that fit.

    Of real robots, whose r* is unknown, the mean estimate itself.
    """
    label = styled(f"{'mean estimate':<{_LABEL}} ", "dim")
    if report.is_of_robots:
        return [label, styled(length(belief.mean_estimate(report)))]
    error = report.mean_estimate_error
    if not math.isfinite(error):
        return [label, styled(UNKNOWN)]
    passed = number(report.tick * report.dt - report.changed_at, ",.1f")
    name = "r_β" if len(report.plans) else "r*"
    if math.isfinite(report.tracking_time):
        took = f"{report.tracking_time:,.1f} s"
        state = "reached"
        words = [f"1 m reached in {took}", f"reached in {took}"]
    elif abs(error) < 1.0:
        state = "not held yet"
        words = [f"1 m not held yet after {passed} s", f"not held yet, {passed} s"]
    else:
        state = "not reached"
        words = [f"1 m not reached after {passed} s", f"not reached, {passed} s"]
    room = width - label.cell_length
    shown = f"{number(error, '+,.2f')} m"
    choices = [
        *(f"{shown} from {name}, {text}" for text in words),
        f"{shown}, {words[-1]}",
        f"{shown}, {state}",
        shown,
    ]
    return [label, styled(next((text for text in choices if len(text) <= room), shown))]


def is_awaited(report: Report, history: Floats) -> bool:
    """True if no separation error [3, k] [m] is known yet: it is averaged over a dither period of each link."""
    return len(report.a) > 0 and not report.is_of_robots and not bool(np.isfinite(history[2]).any())


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
