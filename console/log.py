"""Logs of runs, with their scenarios."""

from pathlib import Path

from world import log_reader, scenario
from world.scenario import Scenario

Log = log_reader.Log[Scenario]


def load(target: Path) -> Log:
    """A log with a tick at least: a file, or that of a run directory; raises FesError in one line."""
    return log_reader.load(target, scenario.parse)
