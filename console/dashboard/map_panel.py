"""The map of the team: positions and headings of robots, and the links between them."""

import math
from dataclasses import dataclass

import numpy as np
from rich.segment import Segment
from rich.style import Style

from console.dashboard.canvas import DOTS_X, DOTS_Y, Canvas, Line
from console.measures.links import FAIR_OUTAGE, POOR_OUTAGE, known_ends, loss, outage_class
from fes.arrays.geometry import HEADING
from fes.arrays.types import Bools, Floats, Ints
from fes.protocol.report import Report

OUTAGE_STYLES = ("green", "yellow", "red")
"""Good, fair and poor links; the last two are drawn dashed, and dotted."""

_DASHES = np.array([[1, 1], [4, 8], [1, 4]])
_LEGEND = (("⠒⠒⠒", f"<{FAIR_OUTAGE:.0%}"), ("⠒⠒ ⠒⠒", f"<{POOR_OUTAGE:.0%}"), ("⠂⠐ ⠂", "more"))
_PALETTE = ("", *OUTAGE_STYLES, "bold", "bold red", "bold yellow")
_LINK, _ROBOT, _DEAD, _CUTTING = 1, 4, 5, 6
_ARROWS = np.array([ord(arrow) for arrow in "→↗↑↖←↙↓↘"], dtype=np.uint32)
_CROSS, _BODY = ord("×"), ord("•")
_MARGIN = 6  # dots on each side of the team: room for a marker and its id
_LEAST_SPAN = 1.0  # m; a smaller team is not magnified further
_MOST = 1e9  # m; robots beyond are not drawn
_ZOOMS = 20  # scales per decade: the map zooms in steps


@dataclass(frozen=True)
class View:
    """Transform from the world to dots, with equal scales in x and y."""

    scale: float
    """Length per dot [m]."""
    west: float
    """x of the leftmost dots [m]"""
    south: float
    """y of the lowest dots [m]"""

    def dots(self, positions: Floats) -> Floats:
        """The dots of `positions` [k, 2] [m]."""
        return (positions - (self.west, self.south)) / self.scale


def view(positions: Floats, width: int, height: int) -> View:
    """The view of `width` x `height` cells that holds all `positions` [k, 2] [m]."""
    size = np.array([width * DOTS_X, height * DOTS_Y], dtype=np.float64)
    if len(positions) == 0:
        positions = np.zeros((1, 2))
    low, high = positions.min(axis=0), positions.max(axis=0)
    room = np.maximum(size - 1.0 - 2.0 * np.minimum(_MARGIN, size // 4), 1.0)
    # The center is rounded to a cell, so that the map does not jitter as robots move: keep half a cell free
    room = np.maximum(room - (DOTS_X, DOTS_Y), 1.0)
    needed = max(_LEAST_SPAN / float(room.max()), float(((high - low) / room).max()))
    scale = 10.0 ** (math.ceil(_ZOOMS * math.log10(needed) - 1e-9) / _ZOOMS)
    cell = np.array([DOTS_X, DOTS_Y]) * scale
    corner = np.rint(0.5 * (low + high) / cell) * cell - 0.5 * (size - 1.0) * scale
    return View(scale, float(corner[0]), float(corner[1]))


def team_map(report: Report, width: int, height: int) -> list[Line]:
    """The map in `width` x `height` cells, with a scale bar in the last line."""
    if width < 1 or height < 2:
        return []
    canvas = Canvas(width, height - 1, _PALETTE)
    positions = report.poses[:, :2]
    shown: Bools = np.all(np.abs(positions) < _MOST, axis=1)  # false for NaN
    seen = view(positions[shown], width, height - 1)
    dots = seen.dots(np.where(shown[:, None], positions, seen.west))
    _links(canvas, report, dots, shown)
    _robots(canvas, report, dots, np.flatnonzero(shown))
    return [*canvas.render(), _scale_bar(seen.scale * DOTS_X, width)]


def legend(report: Report, width: int) -> Line:
    """Line styles of the outage classes, with words if `width` has room for them."""
    line: Line = []
    for (pattern, meaning), style in zip(_LEGEND, OUTAGE_STYLES, strict=True):
        line += [Segment(f" {pattern}", Style.parse(style)), Segment(f" {meaning}")]
    titled = [Segment("lost " if report.is_of_robots else "outage "), *line]
    return titled if sum(segment.cell_length for segment in titled) <= width else line[:-1]


def _links(canvas: Canvas, report: Report, dots: Floats, shown: Bools) -> None:
    known = np.flatnonzero(known_ends(report))
    drawn = known[shown[report.a[known]] & shown[report.b[known]]]
    kind = outage_class(loss(report)[drawn])
    canvas.lines(dots[report.a[drawn]], dots[report.b[drawn]], _LINK + kind, _DASHES[kind])


def _robots(canvas: Canvas, report: Report, dots: Floats, robots: Ints) -> None:
    cells, digits = canvas.width * canvas.height, len(str(len(dots)))
    ink = np.where(report.alive == 1, _ROBOT, _DEAD)
    ink[report.cutting] = _CUTTING
    ink = ink[robots]
    if 4 * len(robots) > cells:  # too many for arrows
        canvas.points(dots[robots, 0], dots[robots, 1], ink)
        return
    column, row = canvas.cell(dots[robots, 0], dots[robots, 1])
    canvas.characters[row, column] = np.where(ink == _DEAD, _CROSS, _arrows(report.poses[robots, HEADING]))
    canvas.ink[row, column] = ink
    if len(robots) * (digits + 2) > cells // 2:  # too many for ids
        return
    for robot, x, y, style in zip(robots.tolist(), column.tolist(), row.tolist(), ink.tolist(), strict=True):
        _name(canvas, str(robot), x, y, style)


def _arrows(heading: Floats) -> Ints:
    known = np.isfinite(heading)
    octant = np.rint(np.where(known, heading, 0.0) % math.tau / (math.pi / 4)).astype(np.int64) % 8
    return np.where(known, _ARROWS[octant], _BODY)


def _name(canvas: Canvas, name: str, column: int, row: int, ink: int) -> None:
    """Write a robot's id beside its marker, off the links and apart from other ids if there is room."""
    size = len(name)
    beside = [(column + 1, row, 0, 1), (column - size, row, 1, 0)]
    above = [(x, y, 1, 1) for y in (row - 1, row + 1) for x in (column, column + 1, column - size)]
    for of_dots, apart in ((True, 1), (False, 1), (False, 0)):
        for x, y, before, after in beside + above:
            if canvas.is_free(x - before * apart, y, size + (before + after) * apart, of_dots):
                canvas.write(x, y, name, ink)
                return


def _scale_bar(cell: float, width: int) -> Line:
    """A bar of a round length at the map's scale of `cell` [m] per cell."""
    most = max(3, width // 3) * cell
    decade = 10.0 ** math.floor(math.log10(most))
    length = max(step * decade for step in (1, 2, 5) if step * decade <= most)
    bar = "─" * max(0, round(length / cell) - 2)
    return [Segment(f"├{bar}┤", Style.parse("dim")), Segment(f" {length:,.15g} m")]
