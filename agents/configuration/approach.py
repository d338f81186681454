"""The approach of each robot by its plan: its goal, its pull, and where it will be when the next plan begins."""

from typing import NamedTuple

import numpy as np

from agents.configuration.planning import NO_SLOT, NONE
from fes.arithmetic import elementary
from fes.arrays import geometry
from fes.arrays.types import Bools, Floats, Ints

Dither = tuple[float, float]
"""Amplitude [m] and frequency [rad/s] of a dither of all links."""


class Approach(NamedTuple):
    """The part of its plan that each of n robots needs at every tick."""

    kind: Ints
    """Kind of the plan [n]; `planning.NONE` without one."""
    slot: Ints
    """Slot [n]."""
    base: Floats
    """Point to which the offset is added: the mean of the marks, or the goal in a contraction [n, 2] [m; world
    frame]."""
    offset: Floats
    """Slot relative to the base [n, 2] [link lengths; world frame]; 0 in a contraction."""
    spacing: Floats
    """Spacing of the plan, without the dither [n] [m]."""
    rate: Floats
    """kappa: rate at which all errors shrink, the same for all robots of a plan [n] [1/s]; 0 without a plan."""
    quality_weight: Floats
    """beta of the plan's shape [n] [1]."""


def none(n: int) -> Approach:
    """The approach of robots without a plan."""
    places, numbers = np.zeros((2, n, 2)), np.zeros((3, n))
    return Approach(np.full(n, NONE), np.full(n, NO_SLOT), *places, *numbers)


def where(is_first: Bools, first: Approach, second: Approach) -> Approach:
    """The `first` approach for the robots where `is_first` [n], the `second` one for the others."""
    return Approach(
        *(
            np.where(is_first if chosen.ndim == 1 else is_first[:, None], chosen, others)
            for chosen, others in zip(first, second, strict=True)
        )
    )


def swing(dither: Dither | None, time: Floats) -> Floats:
    """The dither at `time` [s], any shape [m]; 0 without one."""
    if dither is None:
        return np.zeros_like(time)
    amplitude, frequency = dither
    return amplitude * elementary.sin_cos(frequency * time)[0]


def pull(approach: Approach, positions: Floats, time: Floats, dither: Dither | None, gain: float) -> Floats:
    """Pull of robots at `positions` [n, 2] [m] at `time` [n] [s] by their own clocks, with the linear `gain` [1/s].

    (6) multiplies the pull by the gain, so that robots head to their goals at the common rate [n, 2] [m].
    """
    goal = approach.base + (approach.spacing + swing(dither, time))[:, None] * approach.offset
    return (approach.rate / gain)[:, None] * (goal - positions)


def predicted(
    approach: Approach, positions: Floats, time: Floats, period: float, dither: Dither | None, limit: float | None
) -> Floats:
    """Positions after a `period` [s] of robots that are at `positions` [n, 2] [m] at `time` [n] [s] [n, 2] [m].

    First-order motion at the rate kappa. Toward a goal that moves with the dither A sin(omega t), it ends in
    q(t) = base + (s + G A sin(omega t - phi)) offset, G = kappa / sqrt(kappa^2 + omega^2), tan(phi) = omega / kappa.
    So p(t + T) = q(t + T) + (p - q(t)) exp(-kappa T). No robot gets further than `limit` [m/s] allows. A robot
    without a plan stays.
    """
    decay = elementary.exp(-approach.rate * period)[:, None]
    start, end = (_followed(approach, instant, dither) for instant in (time, time + period))
    way = (end - start) + (start - positions) * (1.0 - decay)
    way = np.where((approach.rate > 0.0)[:, None], way, 0.0)
    if limit is not None:
        length = geometry.separation(way[:, 0], way[:, 1])
        way *= np.minimum(1.0, limit * period / np.maximum(length, 1e-9))[:, None]
    return positions + way


def _followed(approach: Approach, time: Floats, dither: Dither | None) -> Floats:
    """q(t): the motion in which a robot ends at its rate [n, 2] [m]."""
    length = approach.spacing
    if dither is not None:
        amplitude, frequency = dither
        sine, cosine = elementary.sin_cos(frequency * time)
        square = np.maximum(approach.rate * approach.rate + frequency * frequency, 1e-300)
        # kappa A (kappa sin - omega cos) / (kappa^2 + omega^2) = G A sin(omega t - phi)
        length = length + amplitude * approach.rate * (approach.rate * sine - frequency * cosine) / square
    return approach.base + length[:, None] * approach.offset
