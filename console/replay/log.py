"""Logs of runs, with their scenarios."""

from pathlib import Path

from fes.recording import reader
from world.config import scenario
from world.config.scenario import Scenario

Log = reader.Log[Scenario]


def load(target: Path) -> Log:
    """Load a log of at least one tick from a file or a run directory; raises FesError."""
    return reader.load(target, scenario.parse)
