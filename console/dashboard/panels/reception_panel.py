"""The dashboard's panel of a measured run: reception against separation as learnt, true, and counted."""

import math

import numpy as np

from console.dashboard.canvas import DOTS_X, DOTS_Y, Canvas, Line
from console.measures import reception
from console.measures.links import counted
from console.terminal.formatting import number, styled
from fes.arrays.types import Bools, Floats
from fes.protocol.report import Report

BESIDES = 3
"""Lines of the panel below the chart."""

_PALETTE = ("", "magenta", "cyan", "bold")
_TRUE, _LEARNT, _COUNTED = 1, 2, 3
_AXIS = 5
_EVERY = 3  # one in this many dots of the true curve is drawn


def legend(report: Report) -> Line:
    """The marks of the chart; real robots have no true curve."""
    true = [] if report.is_of_robots else [styled("⠂ ⠂", "magenta"), styled(" true ")]
    return [styled("⠒⠒⠒", "cyan"), styled(" learnt "), *true, styled("• counted")]


def panel(report: Report, width: int, height: int) -> list[Line]:
    """`height` lines: the chart, and the parameters of ln(-ln p) = level + exponent ln(r / rho_0)."""
    facts = [
        _fact("level", report.learnt_level, None if report.is_of_robots else report.true_level),
        _fact("exponent", report.learnt_exponent, None if report.is_of_robots else report.true_exponent),
    ]
    known = reception.drawable(report)
    if width - _AXIS < 1 or height <= BESIDES or not known.any():
        return facts
    return [*_chart(report, known, width - _AXIS, height - BESIDES), *facts]


def _chart(report: Report, known: Bools, width: int, height: int) -> list[Line]:
    """`height` lines of `width` cells beside an axis of reception, and a line for the axis of separation."""
    separation, share = report.separation[known], np.clip(counted(report)[known], 0.0, 1.0)
    west, east = reception.separation_range(separation)
    across = np.arange(width * DOTS_X, dtype=np.float64)
    learnt, true = reception.curves(report, west + (east - west) * across / across[-1])
    south, north = _reception_range(np.concatenate([learnt, true, share]))

    canvas = Canvas(width, height, _PALETTE)
    per_part, per_meter = (height * DOTS_Y - 1) / (north - south), across[-1] / (east - west)
    _draw_curve(canvas, across, (true - south) * per_part, _EVERY, _TRUE)
    _draw_curve(canvas, across, (learnt - south) * per_part, 1, _LEARNT)
    _draw_marks(canvas, (separation - west) * per_meter, (share - south) * per_part)

    marks = [f"{north:.0%}", *[""] * (height - 2), f"{south:.0%}"][:height]
    chart = [[styled(f"{mark:>{_AXIS - 1}} ", "dim"), *row] for mark, row in zip(marks, canvas.render(), strict=True)]
    return [*chart, [styled(" " * _AXIS + _axis(west, east, report.optimal_separation, width), "dim")]]


def _draw_curve(canvas: Canvas, x: Floats, y: Floats, every: int, ink: int) -> None:
    """Draw one dot in `every`, or a solid curve for 1; draw nothing if the curve is unknown."""
    if not np.isfinite(y).all():
        return
    if every > 1:
        canvas.points(x[::every], y[::every], np.full(len(x[::every]), ink))
        return
    line = np.column_stack([x, y])
    solid = np.ones((len(line) - 1, 2), dtype=np.int64)
    canvas.lines(line[:-1], line[1:], np.full(len(solid), ink), solid)


def _draw_marks(canvas: Canvas, x: Floats, y: Floats) -> None:
    known = np.isfinite(y)
    for column, row in set(zip(*(cells.tolist() for cells in canvas.cell(x[known], y[known])), strict=True)):
        canvas.write(column, row, "•", _COUNTED)


def _axis(west: float, east: float, optimal: float, width: int) -> str:
    """Labels of both ends of the range [m], and of r* between them if there is room."""
    left, right = f"{west:g} m", f"{east:g} m"
    axis = left + right.rjust(max(1, width - len(left)))
    part = (optimal - west) / (east - west)
    column = round(part * (width - 1)) if 0.0 <= part <= 1.0 else 0
    return (
        f"{axis[:column]}r*{axis[column + 2 :]}" if column > len(left) and column + 2 < width - len(right) else axis
    )


def _reception_range(parts: Floats) -> tuple[float, float]:
    """Range of receptions in twentieths that holds `parts`.

    >>> _reception_range(np.array([0.72, 0.81, math.nan])), _reception_range(np.array([1.0]))
    ((0.7, 0.85), (0.95, 1.0))
    """
    known = parts[np.isfinite(parts)]
    if len(known) == 0:
        return 0.0, 1.0
    low = min(19, math.floor(20.0 * float(known.min())))
    return low / 20.0, max(low + 1, math.ceil(20.0 * float(known.max()))) / 20.0


def _fact(name: str, values: Floats, truth: float | None) -> Line:
    known = values[np.isfinite(values)]
    spread = float(known.max()) - float(known.min()) if len(known) else math.nan
    learnt = f"{number(reception.median(values), '.3f')} (spread {number(spread, '.3f')})"
    return [
        styled(f"{name:<9}", "dim"),
        styled(learnt if truth is None else f"{learnt}, true {number(truth, '.3f')}"),
    ]
