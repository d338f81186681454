"""What a run achieves: errors, connectivity, and times to reach them."""

import math
from dataclasses import dataclass, field

import numpy as np

from fes.arrays import geometry
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model import counts
from fes.model.sensing import OPENING_TICKS, Telemetry
from world.metrics import graphs
from world.metrics.digest import Digest
from world.simulation.neighbor_list import Proximity

HOLD = 10.0
"""A level counts as reached at the first time from which it holds for this long [s], or to the end."""

LEVELS = {
    "disagreement_1m": ("disagreement", 1.0),
    "estimate_1m": ("estimate_error", 1.0),
    "estimate_0_1m": ("estimate_error", 0.1),
    "separation_1m": ("separation_error", 1.0),
    "separation_0_1m": ("separation_error", 0.1),
}
"""Name in the summary -> which quantity must stay below which level [m]."""


@dataclass(eq=False)
class Graph:
    """The components of the graph of some edges, computed once for as long as the edges stay."""

    edges: Edges | None = None
    present: Bools | None = None
    connected: bool = False

    def is_connected(self, edges: Edges, present: Bools) -> bool:
        """Whether all robots that are `present` [n] form one component, without help of the others."""
        if edges is not self.edges or present is not self.present:
            a, b = ends(edges)
            both = present[a] & present[b]
            parts = graphs.component_count(len(edges.ids), a[both], b[both])
            self.edges, self.present = edges, present
            self.connected = bool(parts - np.count_nonzero(~present) <= 1)
        return self.connected


@dataclass(eq=False)
class LinkErrors:
    """Sums up a run, tick by tick; `add` is called once for each tick, in order."""

    dt: float
    ticks: int = 0
    errors: dict[str, float] = field(default_factory=dict)
    """At the last tick: disagreement (NaN before there are links), estimate_error, separation_error [m]."""
    digest: Digest = field(default_factory=Digest)
    disk_now: bool = False
    longest_gap: int = 0
    """Most ticks in a row at which the links of the robots present were not one component."""
    _gap: int = 0
    _linked: int = -1
    """The last tick with a link."""
    _opened: bool = False
    _disk_always: bool = True
    _links_always: bool = True
    _since: dict[str, int | None] = field(default_factory=lambda: dict.fromkeys(LEVELS))
    _reached: dict[str, int] = field(default_factory=dict)
    _disk: Graph = field(default_factory=Graph)
    _links: Graph = field(default_factory=Graph)

    def add(
        self,
        poses: Floats,
        twists: Floats,
        near: Proximity,
        present: Bools,
        open_contacts: bool,
        said: Telemetry,
        separation: Floats,
        optimal: float,
    ) -> None:
        """One tick: true poses [n, 3] and twists [n, 2], who is in range and present, and what robots say they use.

        `separation` are the links' own [u] [m], one for each of `said.links.undirected`; `optimal` is r* [m].
        """
        self.digest.add(self.ticks, poses, twists)
        self.disk_now = self._disk.is_connected(near.edges, present)
        if open_contacts or len(poses) == 1:
            self._opened = True
            self._disk_always &= self.disk_now
            whole = self._links.is_connected(said.links, present)
            self._links_always &= whole
            self._gap = 0 if whole else self._gap + 1
            self.longest_gap = max(self.longest_gap, self._gap)
        if len(said.links) or len(poses) == 1:
            self._linked = self.ticks
        self.errors = link_errors(said, separation, optimal)
        self._levels()
        self.ticks += 1

    @property
    def disk_always(self) -> bool:
        """Whether the disk graph was connected from the tick at which contacts first opened; False if none did."""
        return self._opened and self._disk_always

    @property
    def links_always(self) -> bool:
        """The same for the graph of the links in use."""
        return self._opened and self._links_always

    @property
    def links_lost_at(self) -> float | None:
        """The time [s] from which on no link stood.

        None if one stands at the last tick, if one robot is alone, or if the run is over before a contact can open.
        """
        since = self._linked + 1
        return round(since * self.dt, 9) if since < self.ticks and self.ticks > OPENING_TICKS + 1 else None

    def times(self) -> dict[str, float | None]:
        """For each level the first time [s] from which it held for HOLD, or to the end; None if it never did."""
        found = {name: self._reached.get(name, self._since[name]) for name in LEVELS}
        return {name: None if tick is None else round(tick * self.dt, 9) for name, tick in found.items()}

    def _levels(self) -> None:
        hold = counts.ticks_within(HOLD, self.dt)
        for name, (quantity, level) in LEVELS.items():
            if name in self._reached:
                continue
            since = self._since[name]
            if not self.errors[quantity] < level:
                self._since[name] = None
            elif since is None:
                self._since[name] = self.ticks
            elif self.ticks - since >= hold:
                self._reached[name] = since


def ends(edges: Edges) -> tuple[Ints, Ints]:
    """Rows of the two ends of each undirected edge, among all robots 0 to n - 1."""
    at = edges.undirected
    return edges.rows[at], edges.peers[at]


def separations(poses: Floats, a: Ints, b: Ints) -> Floats:
    """True separation [m] of the robots in rows a and b."""
    x, y = poses[:, geometry.X], poses[:, geometry.Y]
    return geometry.separation(x.take(a) - x.take(b), y.take(a) - y.take(b))


def link_errors(said: Telemetry, separation: Floats, optimal: float) -> dict[str, float]:
    """Disagreement and largest errors [m] over the links in use; NaN where there are none."""
    links, estimates = said.links, said.estimates
    if len(links) == 0:
        return dict.fromkeys(("disagreement", "estimate_error", "separation_error"), math.nan)
    both = links.mutual
    return {
        "disagreement": float(np.abs(estimates.take(both) - estimates.take(links.reverse.take(both))).sum()),
        "estimate_error": float(np.abs(estimates - optimal).max()),
        "separation_error": float(np.abs(separation - optimal).max()),
    }
