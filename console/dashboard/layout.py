"""The layout of a frame: widths by the proportions of the team, and heights by the importance of the panels."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from rich.segment import Segment

from console.dashboard.canvas import Line
from console.dashboard.panels import links_panel
from console.dashboard.panels.map_panel import natural_height, natural_width
from console.terminal.formatting import styled
from fes.arrays.types import Floats
from fes.protocol.report import Report

GAP = 2
"""Cells between two columns."""

UNLIMITED = 10_000
"""Height of a panel that takes all lines that are left."""

_SIDE = (49, 68)  # maximum width of the panels beside the map: by default, and if there is room
_SHARE = 0.43  # of the frame, for these panels
_NARROW_SIDE, _LEFT = 44, 34  # of a small terminal: for a table of links, and for the panels below the map
_LEAST_MAP = 16  # cells of a map that is narrower because its team is


class Columns(NamedTuple):
    """The columns of a wide frame: the map with panels below it, and one or two columns of panels beside it."""

    left: int
    """Width of the map [cells]."""
    map_height: int
    """Lines of the map, with its title and its scale bar."""
    beside: tuple[int, ...]
    """Widths of the columns of panels [cells]."""


class Panel(NamedTuple):
    """A panel that competes for the lines of a column."""

    name: str
    rank: int
    """Panels of a high rank get lines first."""
    heights: tuple[int, int, int, int]
    """Lines: fewest, wanted, ample and most. A panel that does not get the fewest is hidden."""
    draw: Callable[[int], list[Line]]
    """Draws the panel in a number of lines."""
    fit: Callable[[int], int] = lambda height: height
    """The largest useful height up to a given one."""


def columns(report: Report, extent: Floats, width: int, height: int) -> Columns:
    """The columns of `width` x `height` cells for a team of this `extent` [2] [m]."""
    needed, full = links_panel.needed_width(report), links_panel.full_width(report)
    beside_map = max(_NARROW_SIDE, width - GAP - _LEFT)
    side = max(min(needed, _SIDE[0], beside_map), min(int(_SHARE * width), max(_SIDE[1], full)))
    left = width - side - GAP
    tall = 1 + natural_height(extent, left)
    if tall > height:  # the map is as high as the frame, and no wider than its team
        left = min(left, max(_LEAST_MAP, natural_width(extent, height - 1)))
        side = width - left - GAP
    half = (side - GAP) // 2
    is_split = half >= max(needed, _SIDE[0])
    return Columns(left, min(tall, height), (half, side - GAP - half) if is_split else (side,))


def arranged(panels: Sequence[Panel], height: int) -> list[Line]:
    """Panels from top to bottom in `height` lines."""
    lines: list[Line] = []
    for panel, size in zip(panels, share(panels, height), strict=True):
        if size:
            lines += panel.draw(size)
    return lines


def share(panels: Sequence[Panel], height: int) -> list[int]:
    """Lines of each panel; 0 for one that is hidden.

    The most important panel is always shown. Each stage of the heights serves the panels in the order of their rank.
    """
    order = sorted(range(len(panels)), key=lambda index: -panels[index].rank)
    sizes, left = [0] * len(panels), height
    for place, index in enumerate(order):
        fewest = panels[index].heights[0]
        if fewest <= left or place == 0:
            sizes[index] = fewest
            left -= fewest
    for stage in (1, 2, 3):
        for index in order:
            panel, size = panels[index], sizes[index]
            if panel.heights[0] and not size:
                continue
            grown = panel.fit(min(panel.heights[stage], size + max(0, left)))
            if grown > size:
                sizes[index], left = grown, left - (grown - size)
    return sizes


def title(name: str, note: Line, width: int) -> Line:
    """A panel's name, a rule, and a note at its end if there is room."""
    size = sum(segment.cell_length for segment in note)
    if not note or len(name) + size + 5 > width:
        return [styled(name, "bold"), styled(f" {'─' * max(0, width - len(name) - 1)}", "dim")]
    rule = "─" * (width - len(name) - size - 2)
    return [styled(name, "bold"), styled(f" {rule} ", "dim"), *note]


def shape(lines: list[Line], width: int, height: int) -> list[Line]:
    """`lines` cropped and padded to exactly `width` x `height` cells."""
    shaped = [Segment.adjust_line_length(line, width) for line in lines[: max(0, height)]]
    return shaped + [[Segment(" " * width)]] * (height - len(shaped))


def beside(columns: Sequence[tuple[int, list[Line]]], height: int) -> list[Line]:
    """Columns (width, lines) side by side, GAP cells apart, as `height` lines."""
    shaped = [shape(lines, width, height) for width, lines in columns]
    rows: list[Line] = []
    for row in zip(*shaped, strict=True):
        line = list(row[0])
        for part in row[1:]:
            line += [styled(" " * GAP), *part]
        rows.append(line)
    return rows
