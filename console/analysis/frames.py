"""The numbers of an animation: which ticks it shows, and what each of its frames shows."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from console.analysis import history
from console.analysis.history import History
from console.measures import links
from fes.arrays.types import Floats, Ints
from fes.model.table import Use, chosen

SPEED = 5.0
"""Simulated time that a second of the animation shows [s], where the bounds on its length allow it."""

SHORTEST, LONGEST = 4.0, 15.0
"""Bounds on the length of an animation [s]."""

HOLD = 2.0
"""Time for which the last frame stays [s]."""

PATH_SHARE = 0.12
"""Share of the run that a path shows."""

PATH_POINTS = 25
"""Points of a path; it fades in one step less."""

MARGIN = 0.08
"""Margin of the map, as a share of its larger side."""

LEAST_SPAN = 1.0
"""Smallest side of the map [m]."""

LOWEST, DECADES = 1e-3, 6
"""Lowest value of the axis of errors [m], and its largest number of decades."""

TAKES_PART, ALONE, CUTTING, ABSENT = range(4)
"""Condition of a robot: with a link; without one; its loss would cut the links; it takes no part."""


class Playback(NamedTuple):
    """The frames of an animation."""

    ticks: Ints
    """The tick that each frame shows, ascending, from the first to the last [f]."""
    rate: float
    """Frames per second."""


class Bounds(NamedTuple):
    """The part of the plane that the map shows in every frame [m]."""

    west: float
    east: float
    south: float
    north: float


@dataclass(frozen=True, eq=False)
class Frame:
    """The numbers of one frame."""

    time: float
    """[s]"""
    poses: Floats
    """[n, 3] [m, m, rad; world frame]"""
    conditions: Ints
    """TAKES_PART, ALONE, CUTTING or ABSENT of each robot [n]."""
    ends: Floats
    """Both ends of each link in use [l, 2, 2] [m; world frame]."""
    outage: Ints
    """Class of the outage of each link, as in the dashboard: 0 good, 1 fair, 2 poor or unknown [l]."""
    paths: Floats
    """The last positions of each robot, the oldest first [n, PATH_POINTS, 2] [m; world frame]."""


def playback(ticks: int, dt: float, rate: float) -> Playback:
    """The frames of a run of `ticks` ticks of `dt` [s], at about `rate` frames per second.

    A short run has no more frames than ticks, and shows each of them for longer.

    >>> shown = playback(3000, 0.02, 10.0)
    >>> len(shown.ticks), shown.ticks[[0, 1, -1]].tolist(), shown.rate
    (120, [0, 25, 2999], 10.0)
    """
    length = min(max(ticks * dt / SPEED, SHORTEST), LONGEST)
    number = max(1, min(ticks, round(length * rate)))
    shown = np.rint(np.linspace(0.0, ticks - 1.0, number)).astype(np.int64)
    return Playback(shown, min(rate, number / length))


def frame(run: History, tick: int) -> Frame:
    """The frame of a tick."""
    return Frame(
        float(run.time[tick]),
        run.poses[tick],
        conditions(run, tick),
        history.ends_at(run, tick),
        links.outage_class(run.outage[tick]),
        paths(run, tick),
    )


def conditions(run: History, tick: int) -> Ints:
    """The condition of each robot at a tick [n]."""
    links, present = run.links[tick], run.present[tick]
    result = np.full(len(present), ALONE)
    result[links.rows[links.undirected]] = result[links.peers[links.undirected]] = TAKES_PART
    result[history.cutting_at(run, tick)] = CUTTING
    result[~present] = ABSENT
    return result


def paths(run: History, tick: int) -> Floats:
    """The positions of each robot up to a tick, over the last PATH_SHARE of the run [n, PATH_POINTS, 2] [m].

    Before the start a robot stands at its first position.
    """
    first = tick - PATH_SHARE * (len(run.time) - 1)
    ticks = np.maximum(np.rint(np.linspace(first, tick, PATH_POINTS)), 0).astype(np.int64)
    positions: Floats = run.poses[ticks, :, :2].swapaxes(0, 1)
    return positions


def bounds(run: History, aspect: float) -> Bounds:
    """The part of the plane with all positions of a run, for a map whose width is `aspect` times its height."""
    places = run.poses[..., :2].reshape(-1, 2)
    places = places[np.isfinite(places).all(axis=1)]
    low, high = (places.min(axis=0), places.max(axis=0)) if len(places) else (np.zeros(2), np.zeros(2))
    width, height = np.maximum(high - low, LEAST_SPAN) * (1.0 + 2.0 * MARGIN)
    height = max(height, width / aspect)
    (x, y), half = 0.5 * (low + high), (0.5 * height * aspect, 0.5 * height)
    return Bounds(float(x - half[0]), float(x + half[0]), float(y - half[1]), float(y + half[1]))


def error_range(*series: Floats) -> tuple[float, float]:
    """Powers of ten around the values of some errors [t] [m], for a logarithmic axis.

    >>> error_range(np.array([np.nan, 43.0, 0.02]), np.array([0.0, 5.0]))
    (0.01, 100.0)
    """
    values = np.concatenate(series)
    values = values[np.isfinite(values) & (values > 0.0)]
    if not len(values) or values.max() <= LOWEST:
        return LOWEST, 1.0
    high = float(np.ceil(np.log10(values.max())))
    low = max(float(np.floor(np.log10(max(float(values.min()), LOWEST)))), high - DECADES)
    return 10.0 ** min(low, high - 1.0), 10.0**high


def mode(run: History) -> str:
    """The source of the index, such as `index: measured`, or the extension in its place."""
    seeking, controller = run.scenario.seeking, run.scenario.robots.controller
    if controller is not None:
        return f"controller: {chosen(controller).use}"
    return f"law: {chosen(seeking).use}" if isinstance(seeking, Use) else f"index: {seeking.index}"
