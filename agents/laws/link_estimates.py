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
    config: LinkSeekingConfig, draws: Draws, old: Edges, estimates: Floats, new: Edges, entry: Entry
) -> Floats:
    """Estimates with which links begin, for all links `new` [l'] [m]; `estimates` [l] [m] are those of `old`.

    A new link begins with its robot's own mean estimate. A fresh robot, or one without an estimate, takes the
    reported mean instead, and a seeded draw where none was reported.
    """
    mean = (old.sum(estimates) / np.maximum(old.counts, 1)).take(new.rows)
    without_mean = (entry.is_fresh | (old.counts == 0)).take(new.rows)
    reported, first = entry.reported.take(new.rows), first_estimates(config, draws, new)
    return np.where(without_mean, np.where(np.isfinite(reported), reported, first), mean)
