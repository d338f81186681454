"""The map of the team: positions and headings of robots, the links between them, and the paths so far."""

import math
from dataclasses import dataclass

import numpy as np
from rich.segment import Segment
from rich.style import Style

from console.dashboard.canvas import DOTS_X, DOTS_Y, Canvas, Line
from console.measures.links import FAIR_OUTAGE, POOR_OUTAGE, known_ends, loss, outage_class
from console.measures.team import FARTHEST, on_map
from fes.arrays.geometry import HEADING
from fes.arrays.types import Bools, Floats, Ints
from fes.protocol.report import Report

OUTAGE_STYLES = ("green", "yellow", "red")
"""Good, fair and poor links; the last two are drawn dashed, and dotted."""

_DASHES = np.array([[1, 1], [4, 8], [1, 4]])
_LEGEND = (("⠒⠒⠒", f"<{FAIR_OUTAGE:.0%}"), ("⠒⠒ ⠒⠒", f"<{POOR_OUTAGE:.0%}"), ("⠂⠐ ⠂", "more"))
PATH_STYLE, PATH_MARK = "bright_blue", "⠂⠂⠂"
"""The paths of the robots."""

_SHORT_LEGEND = (("⠒⠒", f"<{FAIR_OUTAGE:.0%}"), ("⠒ ⠒", f"<{POOR_OUTAGE:.0%}"))
_PALETTE = ("", PATH_STYLE, *OUTAGE_STYLES, "bold", "bold red", "bold yellow")
_PATH, _LINK, _ROBOT, _DEAD, _CUTTING = 1, 2, 5, 6, 7
_ARROWS = np.array([ord(arrow) for arrow in "→↗↑↖←↙↓↘"], dtype=np.uint32)
_CROSS, _BODY = ord("×"), ord("•")
_MARGIN = 6  # dots on each side of the team: room for a marker and its id
_LEAST_SPAN = 1.0  # m; a smaller team is not magnified further
_ZOOMS = 20  # scales per decade: the map zooms in steps
_PATH_DASH = np.array([[1, 2]])


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
    room = _room(size)
    scale = _zoomed(max(_LEAST_SPAN / float(room.max()), float(((high - low) / room).max())))
    cell = np.array([DOTS_X, DOTS_Y]) * scale
    corner = np.rint(0.5 * (low + high) / cell) * cell - 0.5 * (size - 1.0) * scale
    return View(scale, float(corner[0]), float(corner[1]))


def natural_height(extent: Floats, width: int) -> int:
    """Lines of a map `width` cells wide, with its scale bar, that a team of this `extent` [2] [m] fills.

    >>> natural_height(np.array([200.0, 100.0]), 60), natural_height(np.array([200.0, 0.0]), 60)
    (18, 6)
    """
    return 1 + _natural(extent[::-1], width * DOTS_X, DOTS_X, DOTS_Y)


def natural_width(extent: Floats, height: int) -> int:
    """Cells of a map `height` lines high, with its scale bar, that a team of this `extent` [2] [m] fills."""
    return _natural(extent, (height - 1) * DOTS_Y, DOTS_Y, DOTS_X)


def _natural(extent: Floats, across: int, cell: int, size: int) -> int:
    """Cells of `size` dots that hold extent[0] [m], if extent[1] fills `across` dots in cells of `cell` dots."""
    room = max(across - 1.0 - 2.0 * _MARGIN - cell, 1.0)
    scale = _zoomed(max(_LEAST_SPAN, float(extent[1])) / room)
    return math.ceil((float(extent[0]) / scale + 1.0 + 2.0 * _MARGIN + size) / size)


def _room(size: Floats) -> Floats:
    """Dots of `size` [2] within the margins.

    The center is rounded to a cell, so that the map does not jitter as robots move: half a cell stays free.
    """
    room = np.maximum(size - 1.0 - 2.0 * np.minimum(_MARGIN, size // 4), 1.0)
    return np.maximum(room - (DOTS_X, DOTS_Y), 1.0)


def _zoomed(needed: float) -> float:
    """The next step of the zoom from the scale that is `needed` [m per dot]."""
    return float(10.0 ** (math.ceil(_ZOOMS * math.log10(needed) - 1e-9) / _ZOOMS))


def team_map(report: Report, width: int, height: int, paths: Floats | None = None) -> list[Line]:
    """The map in `width` x `height` cells, with a scale bar in the last line; `paths` are places [t, n, 2] [m]."""
    if width < 1 or height < 2:
        return []
    canvas = Canvas(width, height - 1, _PALETTE)
    positions, shown = report.poses[:, :2], on_map(report)
    seen = view(positions[shown], width, height - 1)
    dots = seen.dots(np.where(shown[:, None], positions, seen.west))
    _links(canvas, report, dots, shown)
    _robots(canvas, report, dots, np.flatnonzero(shown))
    if paths is not None and paths.shape[1:] == positions.shape and not _is_crowded(canvas, len(positions)):
        places = np.concatenate([paths, positions[None]])
        _paths(canvas, seen.dots(np.where(np.abs(places) < FARTHEST, places, np.nan)))
    return [*canvas.render(), _scale_bar(seen.scale * DOTS_X, width)]


def legend(report: Report, width: int, has_paths: bool = False) -> Line:
    """Line styles of the outage classes, and of paths, with the words for which `width` has room."""
    measure = "lost " if report.is_of_robots else "outage "
    full, short = (
        [
            Segment(measure),
            *(
                Segment(text, Style.parse(style) if number % 2 == 0 else None)
                for (pattern, meaning), style in zip(marks, OUTAGE_STYLES, strict=False)
                for number, text in enumerate((f" {pattern}", f" {meaning}"))
            ),
        ]
        for marks in (_LEGEND, _SHORT_LEGEND)
    )
    path = [Segment(f"  {PATH_MARK}", Style.parse(PATH_STYLE)), Segment(" path")] if has_paths else []
    choices = ([*full, *path], [*short, *path], full, short)
    return next((line for line in choices if sum(piece.cell_length for piece in line) <= width), [])


def _paths(canvas: Canvas, dots: Floats) -> None:
    """Draw the paths through `dots` [t, n, 2], sparsely and behind all else, without unknown and far places."""
    size = np.array([canvas.width * DOTS_X, canvas.height * DOTS_Y])
    near = np.all((dots > -size) & (dots < 2 * size), axis=2)  # false for NaN
    cells = np.floor(np.where(near[:, :, None], dots, 0.0) + 0.5)
    drawn = near[:-1] & near[1:] & np.any(cells[:-1] != cells[1:], axis=2)
    start, end = cells[:-1][drawn], cells[1:][drawn]
    canvas.lines(start, end, np.full(len(start), _PATH), np.repeat(_PATH_DASH, len(start), axis=0))


def _is_crowded(canvas: Canvas, robots: int) -> bool:
    """True if the map is too small for an arrow per robot."""
    return 4 * robots > canvas.width * canvas.height


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
    if _is_crowded(canvas, len(robots)):
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
