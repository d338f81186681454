"""The seeking law (18): each robot's estimate of the optimal separation of each of its links.

Each link has three states: the estimate r_hat, its filtered drift xi, and the washout's baseline eta. All links of
one clock have the same dither. `law = "paper"` integrates (18) as printed. Apart from the gradient, it conserves
beta_l r_hat + xi, so two estimates that start d apart remain 2/(2 + beta_l) d apart. `law = "consensus"`, the
default, reverses the sign of the kappa term in xi'. At the paper's own kappa = beta_l^2/4 that makes the derivative
of its Lyapunov function (28) negative definite.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from agents.laws import collocation, link_estimates
from agents.laws.collocation import Step
from agents.laws.link_estimates import NO_SKEW, dither
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.extension.context import Draws
from fes.extension.neighborhood import Entry
from fes.model import counts
from fes.model.seeking import PerturbationConfig

ESTIMATE, DRIFT, BASELINE = 0, 1, 2
"""Rows of the seeking state [3, l]: r_hat [m], xi [m/s], eta [index]."""

WEIGHT = 3
"""Row of a state [4, l]: the quality weight of the index of which eta is the baseline."""

SWEEPS = 4
"""Picard sweeps per step, with the index as a parabola about the path that only drifts. At 2 rad of dither per step
the error stays below 1e-7 of the travel from a start in [50, 90] m. From 25 m, where ln J is steepest, it stays below
1e-5. Three sweeps that evaluate the index anew leave ten times as much."""

MAX_EXTRAPOLATION = 0.1
"""Age [s] up to which a peer's estimate is extrapolated."""


class Index(Protocol):
    """A performance index as a function of separations [m] in an array of any shape."""

    def __call__(self, separation: Floats) -> Floats:
        """The index at `separation` [m]."""

    def parabola(self, separation: Floats) -> tuple[Floats, Floats, Floats]:
        """The index at `separation` [m], its slope [1/m] and half its second derivative [1/m^2]."""

    def trusted(self, separation: Floats) -> Floats:
        """Length [m] on both sides of `separation` [m] over which that parabola counts."""


@dataclass(frozen=True)
class Seeker:
    """The constants of the law for one run: its configuration, its index, and its linear part over a sub-step."""

    config: PerturbationConfig
    index: Index
    dt: float
    """Tick length [s]."""

    @cached_property
    def sub_steps(self) -> int:
        """Steps of the integration per tick."""
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


def begin(seeker: Seeker, tick: int, estimates: Floats) -> Floats:
    """State [3, l] of links that begin at this tick with `estimates` [l] [m]: xi = 0, eta = the first sample.

    (18) leaves eta(0) open. From 0, the transient of the washout would shift the estimate by tens of meters.
    """
    state = np.zeros((3, len(estimates)))
    state[ESTIMATE] = estimates
    sample = seeker.index(estimates + dither(seeker.config, np.array([tick * seeker.dt])))
    state[BASELINE] = sample * seeker.config.index_gain
    return state


def relink(seeker: Seeker, draws: Draws, old: Edges, state: Floats, new: Edges, entry: Entry) -> Floats:
    """State of the links `new`, of as many rows as `state`: that of `state` for a link that `old` has."""
    transition = new.after(old)
    result, is_new = transition.carry(state, np.nan, axis=1), transition.is_new
    if is_new.any():
        begun = new.select(is_new)
        estimates = link_estimates.of_new_links(seeker.config, draws, old, state[ESTIMATE], begun, entry)
        result[:WEIGHT, is_new] = begin(seeker, entry.tick, estimates)
        result[WEIGHT:, is_new] = 1.0
    return result


def extrapolate(seeker: Seeker, state: Floats, heard: Floats, age: Floats) -> Floats:
    """The peers' estimates now [l] [m], from those `heard` [l] [m] `age` [l] [s] ago.

    (18) compares two estimates of the same time, but a beacon is at least a tick old. Both peers climb the same
    index, so meanwhile the peer's estimate has drifted about as much as the robot's own: by xi times age. Without
    this term the exchange slows both down, by 15 % at a delay of 20 ms. A greater age than MAX_EXTRAPOLATION counts
    as MAX_EXTRAPOLATION. The law as printed takes the estimate as it was heard.
    """
    if seeker.config.law == "paper":
        return heard
    now: Floats = heard + state[DRIFT] * np.minimum(age, MAX_EXTRAPOLATION)
    return now


def advance(
    seeker: Seeker, tick: int, state: Floats, heard: Floats, skew: Floats = NO_SKEW, index: Index | None = None
) -> Floats:
    """State [3, l] one tick later; equation (18).

    `heard` [l] [m] is the peer's estimate for the link, held over the tick; NaN where none was heard, which is
    s_ij = 0 in (2). `skew` [l] [s] is that of each link's clock. `index` replaces the seeker's.
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
    """State [3, l] one tick later, by `agents.laws.collocation`; `peer` [l] is the peer's estimate."""
    n = collocation.NODES
    start = np.empty((3, len(peer)))
    start[2] = peer
    for step in range(seeker.sub_steps):
        wave = dither(seeker.config, begin + (step * seeker.dt / seeker.sub_steps) + linear.nodes[:, None])
        held = linear.washout_start * state[BASELINE]
        start[:2] = state[:2]
        drift = np.add.reduce(linear.path_start * start, axis=1)
        path, center = drift, drift[:n] + wave
        value, slope, bend = index.parabola(center)
        trusted = index.trusted(center)
        for _ in range(SWEEPS):
            ahead = path[:n] - drift[:n]
            sample = value + ahead * (slope + ahead * bend)
            is_far = np.abs(ahead) > trusted
            if np.logical_or.reduce(is_far, axis=None):
                sample = np.where(is_far, index(center + ahead), sample)
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
