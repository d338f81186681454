"""A page: its panels in a document, and their update from the reports of a run."""

import time
from importlib import resources
from typing import Protocol

from bokeh.document import Document
from bokeh.models import Div

from console.web import facts
from console.web.charts import Curves, Reception
from console.web.controls import Controls, Send
from console.web.facts import RunFacts, Status
from console.web.history import History
from console.web.link_table import LinkTable
from console.web.slider import TimeSlider
from console.web.team_map import TeamMap
from fes.protocol.report import Report
from fes.system.output import printable

PERIOD = 0.2
"""Time between two updates of the map and the header [s]."""

SLOW_PERIOD = 1.0
"""Time between two updates of the charts and the table [s], whose messages are long."""

STYLE = """
:host { font: 14px/1.35 system-ui, sans-serif; }
.facts { display: flex; flex-wrap: wrap; gap: 1px 18px; align-items: baseline; }
h1 { font-size: 19px; margin: 0; }
span { color: #555; white-space: nowrap; }
b { color: #111; font-variant-numeric: tabular-nums; }
.state { color: #0072B2; }
.bad { color: #D55E00; }
"""


class Source(Protocol):
    """The reports that a page shows."""

    @property
    def version(self) -> int:
        """Number of reports so far."""

    @property
    def history(self) -> History:
        """The history up to the latest report."""

    @property
    def status(self) -> Status:
        """The state of the run."""

    @property
    def known(self) -> float:
        """Time up to which there are reports [s]."""

    def report(self, tick: int | None) -> Report | None:
        """The report of a tick, or the latest one; None before the first."""


class Page:
    """The panels of one browser."""

    def __init__(
        self, document: Document, source: Source, about: RunFacts, send: Send | None, slider: TimeSlider | None
    ) -> None:
        """`send` gives the page controls of the channel, and `slider` those of a recorded run."""
        self._source, self._about, self._slider = source, about, slider
        self._header = Div(name="header", text="", stylesheets=[STYLE], sizing_mode="stretch_width")
        self._map, self._reception, self._table = TeamMap(), Reception(), LinkTable()
        self._curves = Curves(has_cursor=slider is not None)
        controls = slider or (Controls(document, send) if send is not None else None)
        panels = [self._header, self._map.figure, self._curves.errors, self._curves.index, self._reception.figure]
        for root in (*panels, self._table.table, *([controls.row] if controls else [])):
            document.add_root(root)
        document.title = f"fes {printable(about.run)}"
        document.template = resources.files("console.web").joinpath("page.html").read_text(encoding="utf-8")
        document.template_variables["has_controls"] = controls is not None
        self._shown: tuple[int, int] | None = None
        self._drawn_at, self._updated_at = 0.0, time.monotonic()
        self._is_behind = False
        self.update()
        document.add_periodic_callback(self.update, round(1000 * PERIOD))

    def update(self) -> None:
        """Show the present report: the map and the header always, the charts and the table once per SLOW_PERIOD."""
        now = time.monotonic()
        tick = None
        if self._slider is not None:
            self._slider.advance(now - self._updated_at, self._source.known)
            tick = self._slider.tick
        self._updated_at = now
        report = self._source.report(tick)
        text = facts.header(report, self._about, self._source.status)
        if text != self._header.text:
            self._header.text = text
        if report is None:
            return
        state = (self._source.version, report.tick)
        if state != self._shown:
            self._shown, self._is_behind = state, True
            self._map.show(report, self._source.history)
        if self._is_behind and now - self._drawn_at >= SLOW_PERIOD:
            self._drawn_at, self._is_behind = now, False
            self._curves.show(report, self._source.history)
            self._reception.show(report)
            self._table.show(report)
