"""The dashboard: `render(history, width, height)` draws the reports of a run as one frame of text.

In a small terminal the least important panels are hidden first. A frame always has the given size.
"""

import numpy as np
from rich.console import RenderableType
from rich.segment import Segment, SegmentLines

from console.dashboard import links_panel, panels, reception_panel, team_panel
from console.dashboard.canvas import Line
from console.dashboard.header import header
from console.dashboard.map_panel import legend, team_map
from console.measures import reception
from console.measures.team import SERIES, series
from console.terminal.formatting import styled
from fes.arrays.types import Bools, Floats, Ints
from fes.protocol.report import Report

CAPACITY = 1024
"""Number of bins of a history."""

_TWO_COLUMNS = 72  # narrower than this, the panels form one column
_GAP = 2
_SIDE = (49, 68)  # maximum width of the panels beside the map: by default, and if there is room
_LEAST_LINKS = 4  # lines of the links' panel that show one link
_MAX_BARS = 6
_CHART = (4, 14)  # fewest and most lines of the chart of reception
_LEAST_WITH_TEAM, _LEAST_WITH_WHOLE_TEAM = 9, 18  # lines of a column with room for the team's first line, and for all
_LEAST_COLUMN = 20  # lines of a column with room for that chart


class ReportHistory:
    """The latest Report, and the worst values of each bin of ticks of the run so far.

    A bin is one tick wide at first. When all bins are full, pairs of bins are merged.
    """

    def __init__(self) -> None:
        self.latest: Report | None = None
        self.silence = 0.0
        """Time since the last sign of life of a running run [s; wall clock]."""
        self.modes = ""
        """The modes of the gates of real robots, in words."""
        self.expected = "the world"
        """The program or the robots whose first report is awaited."""
        self._clear()

    def add(self, report: Report) -> None:
        """Add a Report; a tick before the latest starts a new run."""
        if self.latest and (report.tick < self.latest.tick or report.scenario != self.latest.scenario):
            self._clear()
        self.latest = report
        while report.tick // self.stride >= CAPACITY:
            self._coarsen()
        index = report.tick // self.stride
        values = series(report)
        self._worst[:, index] = np.fmax(self._worst[:, index], np.where(np.isfinite(values), values, np.nan))
        self._seen[index] = True
        changed = report.changed_at / report.dt if report.dt > 0.0 else 0.0
        if 0.0 < changed <= report.tick:
            self._changed[round(changed) // self.stride] = True

    @property
    def ticks(self) -> tuple[int, int]:
        """First and last tick of the series."""
        return int(self._seen.argmax()) * self.stride, self.latest.tick if self.latest else 0

    def series(self, columns: int) -> Floats:
        """Worst value in each of `columns` equal parts of the run so far [3, columns] [m]; rows: SERIES."""
        seen = np.flatnonzero(self._seen)
        if len(seen) == 0:
            return np.full((len(SERIES), columns), np.nan)
        column = (seen - seen[0]) * columns // (seen[-1] - seen[0] + 1)
        filled, first = np.unique(column, return_index=True)
        worst = np.fmax.reduceat(self._worst[:, seen], first, axis=1)
        # A part without a report repeats the part before it
        held: Floats = worst[:, np.searchsorted(filled, np.arange(columns), side="right") - 1]
        return held

    def changes(self, columns: int) -> Ints:
        """Indices of those of `columns` equal parts of the run so far in which the channel changed [k]."""
        seen, changed = np.flatnonzero(self._seen), np.flatnonzero(self._changed)
        if len(seen) == 0:
            return changed
        inside = changed[(changed > seen[0]) & (changed <= seen[-1])]
        return np.unique((inside - seen[0]) * columns // (seen[-1] - seen[0] + 1))

    def _clear(self) -> None:
        self.stride = 1
        """Ticks per bin."""
        self._worst: Floats = np.full((len(SERIES), CAPACITY), np.nan)
        self._seen: Bools = np.zeros(CAPACITY, dtype=np.bool_)
        self._changed: Bools = np.zeros(CAPACITY, dtype=np.bool_)

    def _coarsen(self) -> None:
        half = CAPACITY // 2
        worst, seen, changed = self._worst, self._seen, self._changed
        stride = 2 * self.stride
        self._clear()
        self.stride = stride
        self._worst[:, :half] = np.fmax(worst[:, 0::2], worst[:, 1::2])
        self._seen[:half] = seen[0::2] | seen[1::2]
        self._changed[:half] = changed[0::2] | changed[1::2]


def render(history: ReportHistory, width: int, height: int) -> RenderableType:
    """One frame of exactly `width` x `height` cells."""
    width, height = max(1, width), max(1, height)
    if history.latest is None:
        frame = _waiting(history.expected, width, height)
    elif width >= _TWO_COLUMNS:
        frame = _wide(history, history.latest, width, height)
    else:
        frame = _narrow(history, history.latest, width, height)
    return SegmentLines(_shape(frame, width, height), new_lines=True)


def _waiting(expected: str, width: int, height: int) -> list[Line]:
    text = f"waiting for {expected}"
    blank: list[Line] = [[] for _ in range((height - 1) // 2)]
    return [*blank, [styled(" " * ((width - len(text)) // 2) + text, "dim")]]


def _wide(history: ReportHistory, report: Report, width: int, height: int) -> list[Line]:
    """The map on the left, the other panels on the right."""
    most = max(_SIDE[1], links_panel.full_width(report))
    side = max(min(links_panel.needed_width(report), _SIDE[0]), min(int(0.43 * width), most))
    left, body = width - side - _GAP, height - 2
    map_lines = [title("Map", legend(report, left - 6), left), *team_map(report, left, body - 1)]
    panel_lines = _column(history, report, side, body, may_grow=True)
    rows = zip(_shape(map_lines, left, body), _shape(panel_lines, side, body), strict=True)
    return [
        *header(report, width, history.silence, history.modes),
        *([*map_row, styled(" " * _GAP), *panel_row] for map_row, panel_row in rows),
    ]


def _narrow(history: ReportHistory, report: Report, width: int, height: int) -> list[Line]:
    """The map above the other panels, if there is room for it."""
    lines, body = header(report, width, history.silence, history.modes), height - 2
    chart = 1 + reception_panel.BESIDES + _CHART[0] if reception.is_measured(report) else 0
    spare = body - 4 - chart - 3 - (2 + len(report.a))  # lines that the other panels at full height leave free
    tall = min(max(spare, 2 * body // 5), width // 2) if body >= 14 else 0
    if tall:
        lines += [title("Map", legend(report, width - 6), width), *team_map(report, width, tall - 1)]
    return lines + _column(history, report, width, body - tall, may_grow=False)


def _column(history: ReportHistory, report: Report, width: int, height: int, may_grow: bool) -> list[Line]:
    """Convergence, reception, links, connectivity and team in `height` lines.

    Reception is hidden first, then connectivity, then the links. Of the team the first line is hidden last.
    """
    reception = _reception(report, width, height)
    team = _team(report, width, height - len(reception))
    height -= len(reception) + len(team)
    connectivity = panels.connectivity(report)
    connectivity_height = 1 + len(connectivity) if height >= 10 + len(connectivity) else 0
    table = 2 + max(1, len(report.a)) if height >= 8 else 0
    is_asked = bool(reception) or report.changed_at > 0.0 or report.is_of_robots
    is_due = is_asked or height - connectivity_height - table >= 2 + len(SERIES)
    tracking = [panels.tracking(report, width)] if is_due and height >= 12 else []
    left = height - connectivity_height - min(table, (height - connectivity_height) // 2 + 1)
    rows = max(1, min(_MAX_BARS, (left - 1 - len(tracking)) // len(SERIES) - 1)) if may_grow else 1
    columns = panels.sparkline_width(width, rows)
    first, last = (tick * report.dt for tick in history.ticks)
    lines = [title("Convergence", [styled(f"log scale, {first:.4g} to {last:.4g} s")], width), *tracking]
    lines += panels.convergence(report, history.series(columns), history.changes(columns), width, rows)
    lines += reception
    room = height + len(reception) - len(lines) - connectivity_height
    if room >= min(table, _LEAST_LINKS) > 0:
        note = [styled(f"{len(report.a):,}, in m, worst error first")]
        lines += [title("Links", note, width), *links_panel.links(report, width, room - 1)]
    if connectivity_height:
        lines += [title("Connectivity", [], width), *connectivity]
    return lines + team


def _team(report: Report, width: int, height: int) -> list[Line]:
    """The panel of the team index in a column of `height` lines: whole, its first line, or nothing."""
    if not report.has_team_index or height < _LEAST_WITH_TEAM:
        return []
    lines = [line for line in team_panel.panel(report, width) if line]
    return [title("Team", [], width), *lines] if height >= _LEAST_WITH_WHOLE_TEAM else lines[:1]


def _reception(report: Report, width: int, height: int) -> list[Line]:
    """The panel of reception in a column of `height` lines; empty unless robots measure."""
    if height < _LEAST_COLUMN or not reception.is_measured(report):
        return []
    chart = min(max(height // 5, _CHART[0]), _CHART[1])
    return [
        title("Reception", reception_panel.legend(report), width),
        *reception_panel.panel(report, width, chart + reception_panel.BESIDES),
    ]


def title(name: str, note: Line, width: int) -> Line:
    """A panel's name, a rule, and a note at its end if there is room."""
    size = sum(segment.cell_length for segment in note)
    if not note or len(name) + size + 5 > width:
        return [styled(name, "bold"), styled(f" {'─' * max(0, width - len(name) - 1)}", "dim")]
    rule = "─" * (width - len(name) - size - 2)
    return [styled(name, "bold"), styled(f" {rule} ", "dim"), *note]


def _shape(lines: list[Line], width: int, height: int) -> list[Line]:
    """`lines` cropped and padded to exactly `width` x `height` cells."""
    shaped = [Segment.adjust_line_length(line, width) for line in lines[: max(0, height)]]
    return shaped + [[Segment(" " * width)]] * (height - len(shaped))
