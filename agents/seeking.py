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

import numpy as np

from fes import draws
from fes.arrays import Bools, Floats
from fes.config import SeekingConfig
from fes.edges import Edges

ESTIMATE, DRIFT, BASELINE = 0, 1, 2
"""Rows of the seeking state [3, l]: r_hat [m], xi [m/s], eta [index]."""

MAX_EXTRAPOLATION = 0.1
"""Age [s] up to which a peer's estimate is extrapolated."""

Index = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Seeker:
    """The constants of the law for one run: configuration, index (with its gain) and time grid."""

    config: SeekingConfig
    index: Index
    dt: float

    @property
    def sub_steps(self) -> int:
        """Runge-Kutta steps a tick."""
        return max(1, math.ceil(self.dt / self.config.sub_step - 1e-9))


def dither(seeker: Seeker, tick: int) -> Floats:
    """a sin(beta_0 t) [m] at the beginning, middle and end of each sub-step of a tick [2 sub_steps + 1]."""
    steps = 2 * seeker.sub_steps
    time = (tick + np.arange(steps + 1) / steps) * seeker.dt
    return seeker.config.dither_amplitude * np.sin(seeker.config.dither_frequency * time)


def first_estimates(seeker: Seeker, seed: int, links: Edges) -> Floats:
    """r_hat_ij(0) [l] [m], uniform in the configured interval; a function of (seed, i, j)."""
    low, high = seeker.config.initial_estimate
    numbers = draws.uniform_pairs(draws.key(seed, "first estimate"), links.ids[links.rows], links.peers)
    return low + (high - low) * numbers


def begin(seeker: Seeker, tick: int, estimates: Floats) -> Floats:
    """State [3, l] of links that begin at this tick with `estimates` [l] [m]: xi = 0, eta = the first sample.

    (18) leaves eta(0) open. From 0, the washout would throw the estimate away by tens of meters.
    """
    state = np.zeros((3, len(estimates)))
    state[ESTIMATE] = estimates
    state[BASELINE] = _sample(seeker, estimates + dither(seeker, tick)[0])
    return state


def relink(seeker: Seeker, seed: int, tick: int, old: Edges, state: Floats, new: Edges, fresh: Bools) -> Floats:
    """State [3, l'] of the new links: carried over where the link stood before.

    A link that is new begins with its robot's own mean estimate; where the robot is `fresh` [n] (or has no
    estimate yet), with a seeded draw.
    """
    at = old.find(new.keys)
    stays = at >= 0
    result = np.empty((3, len(new)))
    if stays.any():
        result[:, stays] = state[:, at[stays]]
    if not stays.all():
        count = np.maximum(old.counts, 1)
        mean = (old.sum(state[ESTIMATE]) / count).take(new.rows)
        drawn = (fresh | (old.counts == 0)).take(new.rows)
        estimates = np.where(drawn, first_estimates(seeker, seed, new), mean)
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
    return heard + state[DRIFT] * np.minimum(age, MAX_EXTRAPOLATION)


def advance(seeker: Seeker, tick: int, state: Floats, heard: Floats) -> Floats:
    """State [3, l] one tick later; equation (18) by classic Runge-Kutta.

    `heard` [l] [m] is the peer's estimate for the link, held over the tick; NaN where none was heard, which is s_ij = 0 of (2).
    """
    if state.shape[1] == 0:
        return state
    config, steps = seeker.config, seeker.sub_steps
    h = seeker.dt / steps
    wave = dither(seeker, tick)
    coupled = np.isfinite(heard)
    pull = np.where(coupled, config.consensus_gain * heard, 0.0)
    gain = np.where(coupled, config.consensus_gain, 0.0)
    sign = config.low_pass_cutoff * (1.0 if config.law == "consensus" else -1.0)
    for step in range(steps):
        first, middle, last = wave[2 * step : 2 * step + 3].tolist()
        k1 = _rate(seeker, state, first, pull, gain, sign)
        k2 = _rate(seeker, state + (0.5 * h) * k1, middle, pull, gain, sign)
        k3 = _rate(seeker, state + (0.5 * h) * k2, middle, pull, gain, sign)
        k4 = _rate(seeker, state + h * k3, last, pull, gain, sign)
        k2 += k3
        k2 *= 2.0
        k2 += k1
        k2 += k4
        k2 *= h / 6.0
        state = state + k2
    return state


def _rate(seeker: Seeker, state: Floats, drive: float, pull: Floats, gain: Floats, sign: float) -> Floats:
    """Right-hand side of (18) [3, l] at dither `drive` [m]; kappa s (r_ji - r_ij) = pull - gain r_ij."""
    config = seeker.config
    rate = np.empty_like(state)
    estimate, drift, baseline = state
    consensus, demodulated, washout = rate
    np.multiply(gain, estimate, out=consensus)
    np.subtract(pull, consensus, out=consensus)
    np.subtract(_sample(seeker, estimate + drive), baseline, out=washout)
    np.multiply(washout, drive, out=demodulated)
    demodulated -= drift
    demodulated *= config.low_pass_cutoff
    demodulated += sign * consensus
    consensus += drift
    washout *= config.washout_cutoff
    return rate


def _sample(seeker: Seeker, separation: Floats) -> Floats:
    """The index times its gain, at `separation` [m]."""
    sample = seeker.index(separation)
    sample *= seeker.config.index_gain
    return sample
