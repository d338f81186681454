"""Bursts of losses: a two-state Markov chain on each directed contact (Gilbert 1960, Elliott 1963).

The state at the first tick in range is drawn from the stationary law. It then makes one step per tick. Its random
numbers are functions of (seed, tick, sender, receiver).
"""

import numpy as np

from fes.arrays.types import Bytes, Floats
from world.config.radio import BurstConfig

GOOD, BAD, UNKNOWN = 0, 1, 2
"""State of a contact; UNKNOWN before its first tick."""


def step(states: Bytes, config: BurstConfig, dt: float, numbers: Floats) -> Bytes:
    """The states [m] a tick of `dt` [s] later, GOOD or BAD, by uniform `numbers` [m]."""
    leave = dt / config.mean_length
    enter = leave * config.bad_share / (1.0 - config.bad_share)
    bad = np.array([enter, 1.0 - leave, config.bad_share])  # by the state before: GOOD, BAD, UNKNOWN
    return (numbers < bad.take(states)).astype(np.uint8)


def reception_factor(states: Bytes, config: BurstConfig) -> Floats:
    """Factor of the bursts on the reception probability, in these states [m]."""
    shares: Floats = np.array([1.0, 1.0 - config.loss]).take(states)
    return shares


def mean_reception_factor(config: BurstConfig | None) -> float:
    """Mean of the factor over the stationary law; 1 without bursts."""
    return 1.0 if config is None else 1.0 - config.bad_share * config.loss
