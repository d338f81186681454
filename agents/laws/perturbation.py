"""The seeking law (18): each robot's estimate of the optimal separation of each of its links.

Per link three states: the estimate r_hat, its filtered drift xi, and the washout's baseline eta. The same
dither is added for all links on one clock. `law = "paper"` integrates (18) as printed; it conserves
beta_l r_hat + xi but for the gradient, so two estimates that start d apart freeze at 2/(2 + beta_l) d.
`law = "consensus"` reverses the sign of the kappa term in xi', which at the paper's own kappa = beta_l^2/4
makes the derivative of its Lyapunov function (28) negative definite. It is the default.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from agents.laws import collocation
from agents.laws.collocation import Step
from fes.arrays import draws
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats
from fes.model import counts
from fes.model.config import SeekingConfig

ESTIMATE, DRIFT, BASELINE = 0, 1, 2
"""Rows of the seeking state [3, l]: r_hat [m], xi [m/s], eta [index]."""

SWEEPS = 3
"""Picard sweeps a step: at 2 rad of dither a step they leave an error below 1e-5 of the travel from a start in
[50, 90] m, and below 1e-3 from 25 m, where ln J is steepest."""

MAX_EXTRAPOLATION = 0.1
"""Age [s] up to which a peer's estimate is extrapolated."""

Index = Callable[[Floats], Floats]
Numbers = Callable[[int, str, Edges], Floats]

FIRST_ESTIMATE, STAGGER = "first estimate", "stagger"
"""Streams of numbers for links; those of the latter are the same at both ends of a link."""


def pair_numbers(seed: int, stream: str, links: Edges) -> Floats:
    """A uniform number in [0, 1) for each link [l]: a function of (seed, stream, i, j)."""
    robots, peers = links.ids[links.rows], links.peers
    if stream == STAGGER:
        robots, peers = np.minimum(robots, peers), np.maximum(robots, peers)
    return draws.uniform_pairs(draws.key(seed, stream), robots, peers)


ON_TIME = np.zeros(1)
"""The skew of clocks that are all right [s]."""


@dataclass(frozen=True)
class Seeker:
    """The constants of the law for one run: configuration, index, and its linear part over a sub-step."""

    config: SeekingConfig
    index: Index
    dt: float
    """Tick length [s]."""
    numbers: Numbers = pair_numbers
    """What draws a number for each link; several runs in one crew have a seed each."""

    @cached_property
    def sub_steps(self) -> int:
        """Steps of the integration a tick."""
        return counts.steps(self.dt, self.config.sub_step)

    @cached_property
    def coupled(self) -> Step:
        """The linear part for a link whose peer is heard, s_ij = 1."""
        return self._step(self.config.consensus_gain)

    @cached_property
    def alone(self) -> Step:
        """The linear part for a link whose peer is not heard, s_ij = 0."""
        return self._step(0.0)

    def _step(self, consensus: float) -> Step:
        config, sign = self.config, 1.0 if self.config.law == "consensus" else -1.0
        length = self.dt / self.sub_steps
        return collocation.step(length, config.low_pass_cutoff, config.washout_cutoff, consensus, sign)


def dither(seeker: Seeker, time: Floats) -> Floats:
    """a sin(beta_0 t) [m] at `time` [s], any shape; the same for all links, on one clock."""
    return seeker.config.dither_amplitude * np.sin(seeker.config.dither_frequency * time)


def stagger(seeker: Seeker, seed: int, links: Edges) -> Floats:
    """How far the dither of each link is ahead of the common one [l] [s], the same at both ends.

    With one phase for all, the formation breathes as a whole: far from its middle robots are carried over many times
    the amplitude, and where shadowing makes the channel a matter of place, a link would learn how reception changes
    with where it is instead of with its length.
    """
    found: Floats | None = links.__dict__.get("stagger")
    if found is None:
        number = seeker.numbers(seed, STAGGER, links)
        found = links.__dict__["stagger"] = 2.0 * math.pi / seeker.config.dither_frequency * number
    return found


def first_estimates(seeker: Seeker, seed: int, links: Edges) -> Floats:
    """r_hat_ij(0) [l] [m], uniform in the configured interval; a function of (seed, i, j)."""
    low, high = seeker.config.initial_estimate
    return low + (high - low) * seeker.numbers(seed, FIRST_ESTIMATE, links)


def begin(seeker: Seeker, tick: int, estimates: Floats) -> Floats:
    """State [3, l] of links that begin at this tick with `estimates` [l] [m]: xi = 0, eta = the first sample.

    (18) leaves eta(0) open. From 0, the washout would throw the estimate away by tens of meters.
    """
    state = np.zeros((3, len(estimates)))
    state[ESTIMATE] = estimates
    sample = seeker.index(estimates + dither(seeker, np.array([tick * seeker.dt])))
    state[BASELINE] = sample * seeker.config.index_gain
    return state


def relink(
    seeker: Seeker, seed: int, tick: int, old: Edges, state: Floats, new: Edges, fresh: Bools, told: Floats
) -> Floats:
    """State [3, l'] of the new links: carried over where the link stood before.

    A link that is new begins with its robot's own mean estimate; where the robot is `fresh` [n] (or has no
    estimate yet), with what its neighbors have `told` it [n] [m]; where that is NaN, with a seeded draw.
    """
    at = new.places_in(old)
    stays = at >= 0
    result = np.empty((3, len(new)))
    if stays.any():
        result[:, stays] = state[:, at[stays]]
    if not stays.all():
        count = np.maximum(old.counts, 1)
        mean = (old.sum(state[ESTIMATE]) / count).take(new.rows)
        drawn = (fresh | (old.counts == 0)).take(new.rows)
        first, told = first_estimates(seeker, seed, new), told.take(new.rows)
        estimates = np.where(drawn, np.where(np.isfinite(told), told, first), mean)
        result[:, ~stays] = begin(seeker, tick, estimates[~stays])
    return result


def extrapolate(seeker: Seeker, state: Floats, heard: Floats, age: Floats) -> Floats:
    """The peers' estimates now [l] [m], from what was `heard` of them `age` [l] [s] ago.

    (18) compares two estimates of the same time, but a beacon is at least a tick old. Both peers climb the
    same index, so meanwhile the other's estimate has drifted about as one's own: by xi age. Without this the
    exchange holds both back, by 15 % at a delay of 20 ms. For an old beacon the drift counts up to
    MAX_EXTRAPOLATION only. The printed law stays literal: it takes the peer's last word as it is.
    """
    if seeker.config.law == "paper":
        return heard
    now: Floats = heard + state[DRIFT] * np.minimum(age, MAX_EXTRAPOLATION)
    return now


def advance(
    seeker: Seeker, tick: int, state: Floats, heard: Floats, skew: Floats = ON_TIME, index: Index | None = None
) -> Floats:
    """State [3, l] one tick later; equation (18).

    `heard` [l] [m] is the peer's estimate for the link, held over the tick; NaN where none was heard, which is
    s_ij = 0 of (2). `skew` is how far each link's clock is ahead [l] [s]. `index` replaces the seeker's.
    """
    if state.shape[1] == 0:
        return state
    begin = tick * seeker.dt + skew
    index = index or seeker.index
    coupled = np.isfinite(heard)
    if np.count_nonzero(coupled) == len(coupled):
        return _integrate(seeker, begin, state, heard, seeker.coupled, index)
    alone = _integrate(seeker, begin, state, np.zeros_like(heard), seeker.alone, index)
    if not coupled.any():
        return alone
    together = _integrate(seeker, begin, state, np.where(coupled, heard, 0.0), seeker.coupled, index)
    return np.where(coupled, together, alone)


def _integrate(seeker: Seeker, begin: Floats, state: Floats, peer: Floats, linear: Step, index: Index) -> Floats:
    """State [3, l] one tick later, by collocation; see `agents.laws.collocation`."""
    n = collocation.NODES
    start = np.empty((3, len(peer)))
    start[2] = peer
    for step in range(seeker.sub_steps):
        wave = dither(seeker, begin + (step * seeker.dt / seeker.sub_steps) + linear.nodes[:, None])
        held = linear.washout_start * state[BASELINE]
        start[:2] = state[:2]
        drift = np.add.reduce(linear.path_start * start, axis=1)
        path = drift
        for _ in range(SWEEPS):
            sample = index(path[:n] + wave)
            sample *= seeker.config.index_gain
            baseline = np.add.reduce(linear.washout_input * sample, axis=1)
            baseline += held
            sample -= baseline[:n]
            sample *= wave
            path = np.add.reduce(linear.path_input * sample, axis=1)
            path += drift
        state = np.empty((3, len(peer)))
        state[:2] = path[n:]
        state[BASELINE] = baseline[n]
    return state
