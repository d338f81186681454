"""Estimates of links in all built-in seeking laws: their first values, and the dither added to them."""

import math

import numpy as np

from fes.arithmetic import elementary
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.extension.context import Draws
from fes.extension.neighborhood import Entry
from fes.model.seeking import LinkSeekingConfig

FIRST_ESTIMATE, STAGGER = "first estimate", "stagger"
"""Streams of random numbers for links."""

NO_SKEW = np.zeros(1)
"""The skew of clocks that are all exact [s]."""


def dither(config: LinkSeekingConfig, time: Floats) -> Floats:
    """a sin(beta_0 t) [m] at `time` [s], any shape; the same for all links, on one clock."""
    return config.dither_amplitude * elementary.sin_cos(config.dither_frequency * time)[0]


def stagger(config: LinkSeekingConfig, draws: Draws, links: Edges) -> Floats:
    """Time by which the dither of each link is ahead of the common one [l] [s], the same at both ends.

    With one phase for all links, the formation oscillates as a whole. Robots far from its center then move by many
    times the amplitude. Under shadowing, which depends on place, a link would learn how reception changes with its
    place, not with its length.
    """
    low, high = np.minimum(links.robots, links.peers), np.maximum(links.robots, links.peers)
    return 2.0 * math.pi / config.dither_frequency * draws(STAGGER, low, high)


def first_estimates(config: LinkSeekingConfig, draws: Draws, links: Edges) -> Floats:
    """r_hat_ij(0) [l] [m], uniform in the configured interval; a function of (seed, i, j)."""
    low, high = config.initial_estimate
    return low + (high - low) * draws(FIRST_ESTIMATE, links.robots, links.peers)


def of_new_links(
    config: LinkSeekingConfig, draws: Draws, old: Edges, estimates: Floats, begun: Edges, entry: Entry
) -> Floats:
    """Estimates with which the new links `begun` [b] begin [b] [m]; `estimates` [l] [m] are those of the links `old`.

    A new link begins with its robot's own mean estimate. A fresh robot, or one without an estimate, takes the
    reported mean instead, and a seeded draw where none was reported. Only the links that need one get a draw.
    """
    mean = old.sum(estimates) / np.maximum(old.counts, 1)
    has_mean = ~entry.is_fresh & (old.counts > 0)
    first = np.where(has_mean, mean, entry.reported).take(begun.rows)
    is_drawn = ~(has_mean | np.isfinite(entry.reported)).take(begun.rows)
    if is_drawn.any():
        first[is_drawn] = first_estimates(config, draws, begun.select(is_drawn))
    return first
