"""The circumstances that the constructor of an extension gets beside its parameters."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fes.arithmetic import draws
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.model.config import ChannelConfig, ObjectiveConfig


class Draws(Protocol):
    """The random numbers of a crew, as a function of a stream and of ids."""

    def __call__(self, stream: str, robots: Ints, peers: Ints) -> Floats:
        """A uniform number in [0, 1) for each pair of ids (robot, peer) [m]; a robot alone is its own peer."""

    def own_ids(self, ids: Ints) -> Ints:
        """The ids within the run of robots with these `ids` in the crew: a crew may hold the robots of many runs."""


@dataclass(frozen=True)
class SeededDraws:
    """The numbers of one run: a function of (seed, stream, robot, peer)."""

    seed: int

    def __call__(self, stream: str, robots: Ints, peers: Ints) -> Floats:
        """A uniform number in [0, 1) for each pair of ids (robot, peer) [m]."""
        return draws.uniform_pairs(draws.key(self.seed, stream), robots, peers)

    def own_ids(self, ids: Ints) -> Ints:
        """The ids themselves."""
        return ids

    def streams(self, stream: str, ids: Ints) -> tuple[Ints, Ints]:
        """The key of the stream for each robot [n, 2], and the id of robot 0 of its run in the crew [n]."""
        return np.tile(draws.key(self.seed, stream), (len(ids), 1)), np.zeros_like(ids)


class KnownChannel(Protocol):
    """The channel as a law with `knows_channel` is told it (`fes.extension.told_channel`)."""

    @property
    def config(self) -> ChannelConfig:
        """Its settings."""

    def probability(self, separation: Floats) -> Floats:
        """Probability that a beacon decodes at `separation` [m], of the same shape."""

    def log_slope(self, separation: Floats) -> Floats:
        """(ln p)' of that probability at `separation` [m], of the same shape [1/m]."""


@dataclass(frozen=True, eq=False)
class LawContext:
    """The circumstances of a law: those of its crew and its run.

    The constructor of a law gets no seed and no generator. A law that needs a number takes it from `draws`. So its
    digits do not depend on its process, on its position in an array, or on the order of calls. For a new number at
    each tick, put the tick into the name of the stream. Sums over a robot's peers go through `Edges.sum`, whose order
    is fixed.
    """

    ids: Ints
    """Ids of the crew, ascending [n]. They need not be the ids in the run: those are `draws.own_ids(ids)`."""
    dt: float
    """Tick length [s]."""
    objective: ObjectiveConfig
    """The separations that the team prefers."""
    draws: Draws
    """Random numbers by stream and ids."""
    skew: Callable[[int, Edges], Floats]
    """Skew of the clock of each link's robot at a tick [l] [s], or [1] if all clocks are exact."""
    channel: KnownChannel | None = None
    """The true channel, for a law with `knows_channel`; None for every other law."""
    dither: tuple[float, float] | None = None
    """Amplitude [m] and frequency [rad/s] of a physical dither that all links share; None without one."""


@dataclass(frozen=True)
class WorldContext:
    """The circumstances of a channel, dynamics or a metric: the world runs them, and they may know the truth."""

    dt: float
    """Tick length [s]."""
    robots: int
    """Number of robots."""
    objective: ObjectiveConfig
    """The separations that the team prefers."""
    draws: Draws
    """Random numbers by stream and ids, of the world's seed."""
