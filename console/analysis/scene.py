"""The picture of one tick: the map with paths, beside the errors with a mark at that time."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from console.analysis import figures, frames
from console.analysis.figures import BLUE, INK, plain
from console.analysis.frames import ABSENT, ALONE, CUTTING, TAKES_PART, Frame
from console.analysis.history import History
from console.measures.links import FAIR_OUTAGE, POOR_OUTAGE
from fes.arrays.geometry import HEADING
from fes.arrays.types import Bytes

if TYPE_CHECKING:
    from matplotlib.artist import Artist

WIDTH, HEIGHT, DPI = 800, 420, 100
"""Size of the picture [px], and pixels per inch of its fonts."""

MAP = (0.082, 0.215, 0.46, 0.66)
ERRORS = (0.635, 0.215, 0.35, 0.66)
"""Left, bottom, width and height of both panels, as shares of the picture."""

AMBER, VERMILION, GRAY = "#E69F00", "#D55E00", "#808080"

COLORS = (INK, BLUE, AMBER, VERMILION, GRAY)
"""All colors of the picture, apart from their shades toward white."""

LINKS: tuple[tuple[str, Any, str], ...] = (
    (BLUE, "-", f"outage < {FAIR_OUTAGE:.0%}"),
    (AMBER, (0, (5, 2)), f"< {POOR_OUTAGE:.0%}"),
    (VERMILION, (0, (1.5, 1.5)), "more"),
)
"""Color, dashes and name of each class of links; color and dashes each distinguish the classes."""

MARKS: dict[int, tuple[str, dict[str, Any], str]] = {
    TAKES_PART: ("o", {"color": INK, "markersize": 5}, "robot"),
    ALONE: ("o", {"color": INK, "markersize": 6, "markerfacecolor": "white"}, "without a link"),
    CUTTING: ("s", {"color": AMBER, "markersize": 8, "markeredgecolor": INK}, "cutting robot"),
    ABSENT: ("X", {"color": VERMILION, "markersize": 8, "markeredgecolor": INK}, "absent"),
}
"""Condition of a robot -> marker, its style and its name."""

MOST_IDS = 30
"""Largest number of robots whose ids are shown."""


class Scene:
    """The picture of a run, which shows one frame at a time."""

    def __init__(self, run: History, shown: Iterable[Frame]) -> None:
        """Draw what all frames share; the legend names the marks of the frames `shown`."""
        figures.require()
        from matplotlib import rc_context
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self._run = run
        with rc_context({"font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False}):
            self.figure: Figure = Figure(figsize=(WIDTH / DPI, HEIGHT / DPI), dpi=DPI)
            self._map, self._errors = (self.figure.add_axes(place) for place in (MAP, ERRORS))
            left, bottom = MAP[0], 0.945
            self.figure.text(left, bottom, plain(run.name or "run"), weight="bold", fontsize=12)
            self._time = self.figure.text(MAP[0] + MAP[2], bottom, "", fontsize=11, ha="right")
            self.figure.text(ERRORS[0] + ERRORS[2], bottom, plain(frames.mode(run)), ha="right")
            self._draw_map()
            self._draw_errors()
            self._draw_legend({int(each) for frame in shown for each in frame.conditions})
        self._canvas: Any = FigureCanvasAgg(self.figure)
        moving = [
            self._paths, *self._links, self._arrows, *self._robots.values(), *self._ids, *self._past, self._cursor,
            *self._texts, self._time,
        ]  # fmt: skip
        self._moving: list[Artist] = moving
        for artist in moving:
            artist.set_animated(True)  # apart from what all frames share, which is drawn once
        self._canvas.draw()
        self._shared = self._canvas.copy_from_bbox(self.figure.bbox)

    def picture(self, frame: Frame) -> Bytes:
        """The picture of a frame [HEIGHT, WIDTH, 3], red, green and blue from 0 to 255."""
        self._show(frame)
        self._canvas.restore_region(self._shared)
        for artist in self._moving:
            self.figure.draw_artist(artist)
        return np.array(self._canvas.buffer_rgba())[..., :3]

    def _show(self, frame: Frame) -> None:
        """Update everything that differs between frames."""
        self._time.set_text(f"t = {frame.time:.1f} s")
        for kind, lines in enumerate(self._links):
            lines.set_segments(list(frame.ends[frame.outage == kind]))
        pieces = np.stack([frame.paths[:, :-1], frame.paths[:, 1:]], axis=2)
        self._paths.set_segments(list(pieces.reshape(-1, 2, 2)))
        positions, headings = frame.poses[:, :2], frame.poses[:, HEADING]
        for condition, marks in self._robots.items():
            marks.set_data(*positions[frame.conditions == condition].T)
        self._arrows.set_offsets(positions)
        is_moving = frame.conditions != ABSENT
        self._arrows.set_UVC(np.where(is_moving, np.cos(headings), 0.0), np.where(is_moving, np.sin(headings), 0.0))
        for label, place in zip(self._ids, positions[: len(self._ids)], strict=True):
            label.xy = place
        self._cursor.set_xdata([frame.time, frame.time])
        past = self._run.time <= frame.time
        for line, values in zip(self._past, self._series(), strict=True):
            line.set_data(self._run.time[past], values[past])

    def _series(self) -> tuple[Any, Any]:
        return self._run.separation_error, self._run.estimate_error_max

    def _draw_map(self) -> None:
        from matplotlib.collections import LineCollection
        from matplotlib.colors import to_rgb
        from matplotlib.patheffects import withStroke

        axes, n = self._map, self._run.poses.shape[1]
        west, east, south, north = frames.bounds(self._run, MAP[2] * WIDTH / (MAP[3] * HEIGHT))
        axes.set(xlim=(west, east), ylim=(south, north), aspect="equal", xlabel="x [m]", ylabel="y [m]")
        fade = np.linspace(0.0, 1.0, frames.PATH_POINTS - 1)[:, None]
        shades = 1.0 - fade * (1.0 - np.array(to_rgb(GRAY)))  # opaque: an older path hides no newer one for long
        self._paths: Any = LineCollection([], colors=np.tile(shades, (n, 1)), linewidths=1.8)
        self._links: list[Any] = [
            LineCollection([], colors=color, linestyles=[dashes], linewidths=1.8) for color, dashes, _ in LINKS
        ]
        for lines in (self._paths, *self._links):
            axes.add_collection(lines, autolim=False)
        scale = 1.0 if n <= MOST_IDS else 0.6
        self._robots = {
            condition: axes.plot([], [], marker, linestyle="", **_scaled(style, scale))[0]
            for condition, (marker, style, _) in MARKS.items()
        }
        none = np.zeros(n)
        self._arrows: Any = axes.quiver(
            none, none, none, none, angles="uv", scale_units="inches", scale=5.0 / scale,
            width=0.006 * scale,
            color=INK,
        )  # fmt: skip
        halo = [withStroke(linewidth=2.0, foreground="white")]
        self._ids = [
            axes.annotate(
                str(robot),
                (0.0, 0.0),
                (-5, 4),
                ha="right",
                textcoords="offset points",
                fontsize=8.5,
                path_effects=halo,
            )
            for robot in range(n if n <= MOST_IDS else 0)
        ]

    def _draw_errors(self) -> None:
        run, axes = self._run, self._errors
        last = max(float(run.time[-1]), run.scenario.run.dt)
        low, high = frames.error_range(*self._series())
        label = f"largest error against ${run.optimum}$ [m]"
        axes.set(xlim=(0.0, last), ylim=(low, high), yscale="log", xlabel="time [s]", ylabel=label)
        axes.yaxis.set_major_formatter("{x:g}")
        axes.grid(alpha=0.3)
        separation = "separation, period mean" if run.averaged else "separation"
        self._past = []
        for values, color, dashes, name in zip(
            self._series(), (BLUE, VERMILION), ("-", "--"), (separation, "estimate"), strict=True
        ):
            axes.plot(run.time, values, color=color, alpha=0.25, linewidth=1.0)
            self._past += axes.plot([], [], dashes, color=color, linewidth=1.8, label=name)
        self._cursor = axes.axvline(0.0, color=INK, linewidth=1.2)
        self._texts = figures.mark_events(axes, run)
        axes.legend(
            frameon=False, ncols=2, loc="lower left", bbox_to_anchor=(-0.02, 0.98), borderaxespad=0.1, fontsize=9,
            handlelength=1.8, handletextpad=0.5, columnspacing=1.0,
        )  # fmt: skip

    def _draw_legend(self, conditions: set[int]) -> None:
        from matplotlib.lines import Line2D

        handles: list[Any] = [
            Line2D([], [], color=color, linestyle=dashes, linewidth=1.8, label=name) for color, dashes, name in LINKS
        ]
        handles += [
            Line2D([], [], marker=marker, linestyle="", label=name, **style)
            for condition, (marker, style, name) in MARKS.items()
            if condition in conditions - {TAKES_PART}
        ]
        self.figure.legend(
            handles=handles, frameon=False, ncols=len(handles), loc="lower left", bbox_to_anchor=(MAP[0] - 0.01, 0.0),
            columnspacing=1.4, handletextpad=0.5, borderaxespad=0.2,
        )  # fmt: skip


def _scaled(style: dict[str, Any], scale: float) -> dict[str, Any]:
    return {**style, "markersize": style["markersize"] * scale}
