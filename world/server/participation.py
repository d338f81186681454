"""The life cycle of the robots at a tick of a run. Each change is logged."""

import logging

import numpy as np

from fes.arrays.types import Bools
from world.execution.barrier import Participants
from world.execution.lifecycle import Lifecycle
from world.simulation.truth import State

_logger = logging.getLogger("world")


def participants(state: State) -> Participants:
    """The robots that take part at the tick of `state`."""
    return Participants(state.tick, state.present, state.since)


def begin_tick(lifecycle: Lifecycle, state: State) -> Bools:
    """The robots that take part at the tick of `state` from now on [n]."""
    return lifecycle.begin_tick(state.tick, state.present & (state.since != state.tick))


def hang(lifecycle: Lifecycle, silent: Bools) -> None:
    """Exclude the `silent` robots [n], which did not answer in time, and all robots of the same process."""
    for robot in lifecycle.silent(silent):
        _logger.warning("robot %d does not answer", robot)


def log_changes(before: State, after: State) -> None:
    """Log the robots that take part in only one of two states."""
    for robot in np.flatnonzero(before.present & ~after.present).tolist():
        _logger.info("robot %d is absent from tick %d on: its body stands still", robot, after.tick)
    for robot in np.flatnonzero(after.present & ~before.present).tolist():
        _logger.info("robot %d is back from tick %d on", robot, after.tick)
