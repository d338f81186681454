"""The charts of a page: errors and team index over time, and reception over separation."""

import math
from typing import Any

from bokeh.models import ColumnDataSource, CustomJSTickFormatter, HoverTool, NumeralTickFormatter, Span
from bokeh.plotting import figure

from console.measures import reception, team
from console.web import columns
from console.web.columns import BLUE, FADED, INK, ORANGE, RED
from console.web.history import SERIES, History
from fes.protocol.report import Report

HEIGHT = 230
"""Height of a chart [pixels]."""

_STYLES = ((BLUE, "solid"), (ORANGE, "dashed"), (RED, "dotdash"))
_LABELS = tuple(team.SERIES.values())


class Curves:
    """The measures of convergence and the team index over the run, on log axes."""

    def __init__(self, has_cursor: bool) -> None:
        """`has_cursor` marks the time that is shown, for a log: its curves show the whole run."""
        self._values = source("curves", "time", *SERIES, "index", "target")
        self._changes = source("changes", "time")
        self._cursor = Span(dimension="height", line_color=INK, line_width=1, visible=has_cursor)
        self.errors = _chart("errors", "time [s]", "largest value [m]", "log")
        self.index = _chart("index", "time [s]", "team index F [1]", "log")
        self._draw(self.errors, SERIES, _LABELS, " m")
        self._draw(self.index, ("index", "target"), ("index", "target"), "")

    def show(self, report: Report, history: History) -> None:
        """Show the history, and the time of a report."""
        self._values.data = history.curves()
        self._changes.data = history.changes()
        self._cursor.location = report.tick * report.dt
        self.index.visible = report.has_team_index

    def _draw(self, plot: Any, names: tuple[str, ...], labels: tuple[str, ...], unit: str) -> None:
        drawn = [
            _line(plot, self._values, "time", name, style, label)
            for name, label, style in zip(names, labels, _STYLES, strict=False)
        ]
        plot.vspan("time", source=self._changes, color=FADED, line_dash="dotted")
        legend_key(plot, "channel changed", FADED, "dotted")
        plot.add_layout(self._cursor)
        tips = [(label, f"@{name}{{%.4g}}{unit}") for name, label in zip(names, labels, strict=True)]
        forms = {f"@{name}": "printf" for name in names}
        tips = [("time", "@time{0.00} s"), *tips]
        plot.add_tools(HoverTool(renderers=drawn[:1], tooltips=tips, formatters=forms, mode="vline"))
        settle_legend(plot)


class Reception:
    """Reception over separation: as robots have learnt it, as it is, and as they count it."""

    def __init__(self) -> None:
        self._learnt, self._true = (source(name, "separation", "reception") for name in ("learnt", "true"))
        self._counted = source("counted", "link", "separation", "decoded", "learnt", "true")
        plot = self.figure = _chart("reception", "separation [m]", "reception", "linear")
        plot.visible = False
        plot.yaxis.formatter = NumeralTickFormatter(format="0%")
        learnt = _line(plot, self._learnt, "separation", "reception", _STYLES[0], "learnt")
        _line(plot, self._true, "separation", "reception", _STYLES[1], "true")
        dots = plot.scatter("separation", "decoded", source=self._counted, color=INK, size=6, legend_label="counted")
        shares = [
            (label, f"@{name}{{0.0%}}") for label, name in (("counted", "decoded"), ("learnt",) * 2, ("true",) * 2)
        ]
        of_links = [("link", "@link"), ("separation", "@separation{0.00} m"), *shares]
        of_curve = [("separation", "@separation{0.0} m"), ("learnt", "@reception{0.0%}")]
        plot.add_tools(
            HoverTool(renderers=[dots], tooltips=of_links),
            HoverTool(renderers=[learnt], tooltips=of_curve, line_policy="interp"),
        )
        settle_legend(plot)

    def show(self, report: Report) -> None:
        """Show a report, if its robots measure the channel."""
        self.figure.visible = reception.is_measured(report)
        if self.figure.visible:
            self._learnt.data, self._true.data = columns.curves(report)
            self._counted.data = columns.counted(report)


def source(name: str, *fields: str) -> Any:
    """A source of data with these columns, empty at first."""
    return ColumnDataSource({field: [] for field in fields}, name=name)


def _chart(name: str, x: str, y: str, axis: str) -> Any:
    plot = figure(
        name=name,
        height=HEIGHT,
        sizing_mode="stretch_width",
        x_axis_label=x,
        y_axis_label=y,
        y_axis_type=axis,
        tools="pan,box_zoom,reset,save",
    )
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    if axis == "log":
        plot.yaxis.formatter = CustomJSTickFormatter(code="return String(Number(tick.toPrecision(4)))")
    return plot


def _line(plot: Any, data: Any, x: str, y: str, style: tuple[str, str], label: str) -> Any:
    color, dash = style
    return plot.line(x, y, source=data, color=color, line_dash=dash, line_width=2, legend_label=label)


def legend_key(plot: Any, label: str, color: str, dash: str) -> None:
    """Add an entry to the legend, which stays even while nothing is drawn in its style."""
    plot.line([math.nan], [math.nan], color=color, line_dash=dash, line_width=2, legend_label=label)


def settle_legend(plot: Any) -> None:
    """Put the legend above the plot, where it hides no curve."""
    plot.legend.orientation = "horizontal"
    plot.legend.border_line_color = None
    plot.legend.padding = 0
    plot.legend.spacing = 14
    plot.add_layout(plot.legend[0], "above")
