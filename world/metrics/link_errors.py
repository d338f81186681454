"""Errors over the links in use, connectivity of the graphs, and the times from which errors stay low."""

import math
from dataclasses import dataclass, field

import numpy as np

from fes.arithmetic import sums
from fes.arrays import geometry
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model import counts
from fes.model.quantities import LEVELS
from fes.model.sensing import OPENING_TICKS, Telemetry
from world.metrics import graphs
from world.metrics.digest import Digest
from world.metrics.tick_truth import TickTruth
from world.simulation.core import compiled_world

HOLD = 10.0
"""An error has reached its level at the first time from which it stays below it for this long [s], or to the end."""


NUMBERS = "disagreement", "estimate_error", "separation_error", "estimate"
"""Sum of the differences of two estimates of one link, largest errors of estimates and separations, mean estimate."""


@dataclass(eq=False)
class Graph:
    """Connectivity of a graph, computed again only when its edges or the robots present change."""

    edges: Edges | None = None
    present: Bools | None = None
    connected: bool = False

    def is_connected(self, edges: Edges, present: Bools) -> bool:
        """True if all robots that are `present` [n] form one component by edges between them alone."""
        if edges is not self.edges or present is not self.present:
            self.edges, self.present = edges, present
            self.connected = graphs.parts(present, *ends(edges)) <= 1
        return self.connected


@dataclass(eq=False)
class LinkErrors:
    """Errors and connectivity of a run; call `add` once per tick, in order."""

    dt: float
    ticks: int = 0
    errors: dict[str, float] = field(default_factory=dict)
    """Numbers of the last tick [m], as `link_errors` gives them."""
    digest: Digest = field(default_factory=Digest)
    disk_now: bool = False
    """True if the disk graph is connected at the last tick."""
    longest_gap: int = 0
    """Largest number of consecutive ticks at which the links did not connect all robots present."""
    _gap: int = 0
    _linked: int = -1
    """Last tick with a link."""
    _opened: bool = False
    _disk_always: bool = True
    _links_always: bool = True
    _since: dict[str, int | None] = field(default_factory=lambda: dict.fromkeys(LEVELS))
    _reached: dict[str, int] = field(default_factory=dict)
    _disk: Graph = field(default_factory=Graph)
    _links: Graph = field(default_factory=Graph)

    def add(self, truth: TickTruth) -> None:
        """Add a tick."""
        state, links = truth.state, truth.telemetry.links
        is_alone = len(state.poses) == 1
        self.digest.add(self.ticks, state.poses, truth.twists)
        self.disk_now = self._disk.is_connected(state.proximity.edges, state.present)
        if state.sent > 0 or is_alone:
            self._opened = True
            self._disk_always &= self.disk_now
            is_connected = self._links.is_connected(links, state.present)
            self._links_always &= is_connected
            self._gap = 0 if is_connected else self._gap + 1
            self.longest_gap = max(self.longest_gap, self._gap)
        if len(links) or is_alone:
            self._linked = self.ticks
        self.errors = link_errors(truth.telemetry, truth.mean_separation, truth.optimal)
        self._update_levels()
        self.ticks += 1

    @property
    def disk_always(self) -> bool:
        """True if the disk graph was connected at each tick since the first contact; False without a contact."""
        return self._opened and self._disk_always

    @property
    def links_always(self) -> bool:
        """True if the links in use connected all robots at each tick since the first contact; False without one."""
        return self._opened and self._links_always

    @property
    def links_lost_at(self) -> float | None:
        """Time from which no robot had a link [s].

        None if a robot has a link at the last tick, if there is only one robot, or if no contact could open yet.
        """
        since = self._linked + 1
        return round(since * self.dt, 9) if since < self.ticks and self.ticks > OPENING_TICKS + 1 else None

    def times(self) -> dict[str, float | None]:
        """For each level the first time [s] from which its error stayed below it, as HOLD says; None without one."""
        ticks = {name: self._reached.get(name, self._since[name]) for name in LEVELS}
        return {name: None if tick is None else round(tick * self.dt, 9) for name, tick in ticks.items()}

    def _update_levels(self) -> None:
        for name, (error, level) in LEVELS.items():
            if name in self._reached:
                continue
            since = self._since[name]
            if not self.errors[error] < level:
                self._since[name] = None
            elif since is None:
                self._since[name] = self.ticks
            elif self.ticks - since >= counts.ticks_within(HOLD, self.dt):
                self._reached[name] = since


def ends(edges: Edges) -> tuple[Ints, Ints]:
    """Rows of the two ends of each undirected edge; the rows are all robots, 0 to n - 1."""
    undirected = edges.undirected
    return edges.rows[undirected], edges.peers[undirected]


def separations(poses: Floats, a: Ints, b: Ints) -> Floats:
    """True separation [m] of the robots in rows a and b."""
    x, y = poses[:, geometry.X], poses[:, geometry.Y]
    return geometry.separation(x.take(a) - x.take(b), y.take(a) - y.take(b))


def link_separations(links: Edges, poses: Floats) -> Floats:
    """True separation of each of `links.undirected` [u] [m]."""
    kernels = compiled_world.link_kernels()
    return separations(poses, *ends(links)) if kernels is None else kernels.separations(links, poses)


def link_errors(telemetry: Telemetry, separation: Floats, optimal: float) -> dict[str, float]:
    """Disagreement, largest errors, and mean estimate over the links in use [m]; NaN without links."""
    links, estimates = telemetry.links, telemetry.estimates
    if len(estimates) == 0:
        return dict.fromkeys(NUMBERS, math.nan)
    kernels = compiled_world.link_kernels()
    numbers = _numbers if kernels is None else kernels.errors
    disagreement, of_estimates, of_separations, total = numbers(links, estimates, separation, optimal)
    return {
        "disagreement": disagreement,
        "estimate_error": of_estimates,
        "separation_error": of_separations,
        "estimate": total / len(estimates),
    }


def _numbers(links: Edges, estimates: Floats, separation: Floats, optimal: float) -> list[float]:
    """Disagreement, largest errors, and sum of the estimates: the definition of the compiled numbers."""
    mutual = links.mutual
    return [
        sums.total(np.abs(estimates.take(mutual) - estimates.take(links.reverse.take(mutual)))),
        float(np.abs(estimates - optimal).max()),
        float(np.abs(separation - optimal).max()),
        sums.total(estimates),
    ]
