"""Logs of runs, with their scenarios."""

from pathlib import Path

from fes.recording import reader
from world.config import scenario
from world.config.scenario import Scenario

Log = reader.Log[Scenario]


def load(target: Path) -> Log:
    """A log with a tick at least: a file, or that of a run directory; raises FesError in one line."""
    return reader.load(target, scenario.parse)
