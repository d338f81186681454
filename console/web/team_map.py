"""The map of the team in two dimensions: paths, links by outage, robots by heading and state."""

from typing import Any

import numpy as np
from bokeh.models import CDSView, GroupFilter, HoverTool
from bokeh.plotting import figure

from console.measures import team
from console.web import columns
from console.web.charts import legend_key, settle_legend, source
from console.web.columns import ARROW, DASHES, FADED, LINK_COLORS, QUALITIES
from console.web.history import History
from fes.protocol.report import Report

ROBOT = ("robot", "x", "y", "tail", "angle", "heading", "marker", "color", "state")
LINK = ("link", "x0", "y0", "x1", "y1", "quality", "separation", "estimate_a", "estimate_b", "outage", "decoded")
"""Columns that the map draws, and names to a person who points at a robot or a link."""

TIPS_OF_ROBOTS = [
    ("robot", "@robot"),
    ("position", "(@x{0.00}, @y{0.00}) m"),
    ("heading", "@heading{0.0}°"),
    ("state", "@state"),
]
TIPS_OF_LINKS = [
    ("link", "@link"),
    ("separation", "@separation{0.00} m"),
    ("estimates", "@estimate_a{0.00} m, @estimate_b{0.00} m"),
    ("outage", "@outage{0.0%}"),
    ("decoded", "@decoded{0.0%}"),
]


class TeamMap:
    """A figure with equal scales in x and y, which follows the team until a person zooms."""

    def __init__(self) -> None:
        self._paths = source("paths", "x", "y")
        self._links = source("links", *LINK)
        self._robots = source("robots", *ROBOT)
        plot = self.figure = figure(
            name="map",
            match_aspect=True,
            sizing_mode="stretch_both",
            min_height=330,
            x_axis_label="x [m]",
            y_axis_label="y [m]",
            tools="pan,wheel_zoom,box_zoom,reset,save",
            active_scroll="wheel_zoom",
        )
        plot.line("x", "y", source=self._paths, color=FADED, alpha=0.8, line_width=1)
        links = [self._class(*style) for style in zip(QUALITIES, LINK_COLORS, DASHES, strict=True)]
        bodies = {"source": self._robots, "line_color": "color", "line_width": 2}
        plot.ray("tail", "y", angle="angle", length=ARROW, length_units="screen", **bodies)
        robots = plot.scatter("x", "y", marker="marker", size=10, fill_color="color", **bodies)
        plot.text(
            "x", "y", text="robot", source=self._robots, x_offset=9, y_offset=-5,
            text_font_size="12px", text_color="color",
        )  # fmt: skip
        plot.add_tools(
            HoverTool(renderers=[robots], tooltips=TIPS_OF_ROBOTS),
            HoverTool(renderers=links, tooltips=TIPS_OF_LINKS, line_policy="interp"),
        )
        settle_legend(plot)
        plot.toolbar.logo = None

    def show(self, report: Report, history: History) -> None:
        """Show a report, with the paths up to its tick."""
        self._paths.data = history.paths(report.tick)
        self._links.data = columns.lines(report)
        self._robots.data = columns.robots(report)
        if not np.any(team.on_map(report)):
            self._paths.data = {"x": np.zeros(0), "y": np.zeros(0)}

    def _class(self, quality: str, color: str, dash: str) -> Any:
        """The links of a class of outage."""
        view = CDSView(filter=GroupFilter(column_name="quality", group=quality))
        legend_key(self.figure, f"outage {quality}", color, dash)
        style = {"color": color, "line_dash": dash, "line_width": 2}
        return self.figure.segment("x0", "y0", "x1", "y1", source=self._links, view=view, **style)
