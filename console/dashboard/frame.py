"""The dashboard: `render(history, width, height)` draws the reports of a run as one frame of text.

In a small terminal the least important panels are hidden first. A frame always has the given size.
"""

from functools import partial

from rich.console import RenderableType
from rich.segment import SegmentLines

from console.dashboard import layout
from console.dashboard.canvas import Line
from console.dashboard.header import header
from console.dashboard.history import ReportHistory
from console.dashboard.layout import Panel, title
from console.dashboard.panels import (
    connectivity,
    convergence,
    legend,
    links_panel,
    map_panel,
    reception_panel,
    team_panel,
)
from console.measures import reception
from console.measures.team import SERIES
from console.terminal.formatting import styled
from fes.protocol.report import Report

_TWO_COLUMNS = 72  # narrower than this, the panels form one column
_LEAST_MAP = 14  # lines of a narrow body with room for a map
_LEAST_LINKS = 4  # lines of the links' panel that show one link
_AMPLE_BARS = 4  # lines of each series before others get more room
_TALL = 26  # lines of a column in which the convergence has bars at least
_CHART = (4, 8, 14)  # fewest, ample and most lines of the chart of reception
_LEAST_WITH_RECEPTION = 20  # lines of a column with room for that chart


def render(history: ReportHistory, width: int, height: int) -> RenderableType:
    """One frame of exactly `width` x `height` cells."""
    width, height = max(1, width), max(1, height)
    if history.latest is None:
        frame = _waiting(history.expected, width, height)
    else:
        report = history.latest
        frame = header(report, width, history.silence, history.modes, history.source)
        draw = _wide if width >= _TWO_COLUMNS else _narrow
        frame += draw(history, report, width, height - len(frame))
    return SegmentLines(layout.shape(frame, width, height), new_lines=True)


def _waiting(expected: str, width: int, height: int) -> list[Line]:
    text = f"waiting for {expected}"
    blank: list[Line] = [[] for _ in range((height - 1) // 2)]
    return [*blank, [styled(" " * ((width - len(text)) // 2) + text, "dim")]]


def _wide(history: ReportHistory, report: Report, width: int, height: int) -> list[Line]:
    """The map on the left, the other panels on the right; those that fit in the space below the map are there."""
    plan = layout.columns(report, history.extent, width, height)
    right = [*plan.beside, 0][:2]
    links, connected, team = (make(report, plan.left) for make in (_links, _connectivity, _team))
    below, room = list[Panel](), height - plan.map_height
    tables = [links] if plan.left >= links_panel.needed_width(report) else []
    for panel in (team, connected, *tables):
        if panel is not None and panel.heights[1] <= room:
            below.append(panel)
            room -= panel.heights[1]
    moved = {panel.name for panel in below}
    first = [_convergence(history, report, plan.beside[0], height), _reception(report, plan.beside[0], height)]
    others = [make(report, right[1] or right[0]) for make in (_links, _connectivity, _team)]
    rest = [panel for panel in others if panel is not None and panel.name not in moved]
    words = partial(_legend, history, report)
    if room >= legend.LEAST:
        below.append(words(plan.left))
    else:
        rest.append(words(right[1] or right[0]))
    map_height = plan.map_height + (room if room < legend.LEAST else 0)
    left = [*_map(history, report, plan.left, map_height), *layout.arranged(below, height - map_height)]
    stacks = [[panel for panel in first if panel is not None], rest]
    if len(plan.beside) == 1:
        stacks = [[*stacks[0], *stacks[1]]]
    drawn = [layout.arranged(stack, height) for stack in stacks]
    columns = [(plan.left, left), *zip(plan.beside, drawn, strict=True)]
    return layout.beside(columns, height)


def _narrow(history: ReportHistory, report: Report, width: int, height: int) -> list[Line]:
    """The map above the other panels, if there is room for it."""
    chart = 1 + reception_panel.BESIDES + _CHART[0] if reception.is_measured(report) else 0
    spare = height - 4 - chart - 3 - (2 + len(report.a))  # lines that the other panels at full height leave free
    natural = 1 + map_panel.natural_height(history.extent, width)
    tall = min(max(spare, 2 * height // 5), natural, width // 2) if height >= _LEAST_MAP else 0
    body = height - tall
    panels = [
        _convergence(history, report, width, body),
        _reception(report, width, body),
        _links(report, width),
        _connectivity(report, width),
        _team(report, width),
        _legend(history, report, width),
    ]
    shown = layout.arranged([panel for panel in panels if panel is not None], body)
    return [*(_map(history, report, width, tall) if tall else []), *shown]


def _map(history: ReportHistory, report: Report, width: int, height: int) -> list[Line]:
    note = map_panel.legend(report, width - len("Map") - 5, has_paths=len(history.paths) > 1)
    return [title("Map", note, width), *map_panel.team_map(report, width, height - 1, history.paths)]


def _convergence(history: ReportHistory, report: Report, width: int, height: int) -> Panel:
    """The convergence: a line for each series, or as many lines of bars as there is room for."""
    first, last = (tick * report.dt for tick in history.ticks)
    note = [styled(f"log scale, {first:.4g} to {last:.4g} s")]
    plain = int(convergence.is_awaited(report, history.series(1)))  # a line without bars
    series = len(SERIES) - plain

    def bars(height: int) -> int:
        return max(1, (height - 2 - plain) // series - 1)

    def fit(height: int) -> int:
        return 2 + plain + series * (1 + bars(height)) if bars(height) > 1 else min(height, 2 + plain + series)

    def draw(height: int) -> list[Line]:
        rows = bars(height)
        tracking = [convergence.tracking(report, width)] if height >= 2 + plain + series else []
        columns = convergence.sparkline_width(width, rows)
        values, changes = history.series(columns), history.changes(columns)
        return [
            title("Convergence", note, width),
            *tracking,
            *convergence.convergence(report, values, changes, width, rows),
        ]

    lines_only = 2 + plain + series
    wanted = lines_only if height < _TALL else max(lines_only, fit(height // 2 - 2))
    ample = max(wanted, 2 + plain + series * (1 + _AMPLE_BARS))
    return Panel("convergence", 9, (1 + plain + series, wanted, ample, layout.UNLIMITED), draw, fit)


def _reception(report: Report, width: int, height: int) -> Panel | None:
    """The chart of reception, if robots measure it."""
    if height < _LEAST_WITH_RECEPTION or not reception.is_measured(report):
        return None
    least, ample, most = (1 + reception_panel.BESIDES + chart for chart in _CHART)

    def draw(height: int) -> list[Line]:
        note = reception_panel.legend(report)
        return [title("Reception", note, width), *reception_panel.panel(report, width, height - 1)]

    return Panel("reception", 5, (least, least, ample, most), draw)


def _links(report: Report, width: int) -> Panel:
    """The table of the links in use."""
    full = 2 + max(1, len(report.a))

    def draw(height: int) -> list[Line]:
        note = [styled(f"{len(report.a):,}, in m, worst error first")]
        return [title("Links", note, width), *links_panel.links(report, width, height - 1)]

    return Panel("links", 7, (min(full, _LEAST_LINKS), full, full, full), draw)


def _connectivity(report: Report, width: int) -> Panel:
    shown = connectivity.connectivity(report)
    size = 1 + len(shown)
    return Panel("connectivity", 6, (size,) * 4, lambda height: [title("Connectivity", [], width), *shown])


def _team(report: Report, width: int) -> Panel | None:
    """The team index, if it is computed: the whole panel, or its first line."""
    if not report.has_team_index:
        return None
    shown = [line for line in team_panel.panel(report, width) if line]
    size = 1 + len(shown)

    def draw(height: int) -> list[Line]:
        return [title("Team", [], width), *shown] if height >= size else shown[:1]

    return Panel("team", 8, (1, size, size, size), draw, lambda height: size if height >= size else 1)


def _legend(history: ReportHistory, report: Report, width: int) -> Panel:
    """The words on the screen, in the lines that the other panels leave free."""
    full = 1 + len(legend.entries(report, history.source))
    ample = min(full, 9)

    def draw(height: int) -> list[Line]:
        return [title("Legend", [], width), *legend.legend(report, history.source, width, height - 1)]

    return Panel("legend", 1, (0, 0, ample, full), draw, lambda height: height if height >= legend.LEAST else 0)
