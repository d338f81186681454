"""Logs of runs, with their scenarios."""

from pathlib import Path

from fes.recording import reader
from world.config import scenario
from world.config.scenario import Scenario

Log = reader.Log[Scenario]


def load(target: Path) -> Log:
    """Load a log of at least one tick from a file or a run directory; raises FesError."""
    return reader.load(target, scenario.parse)


def length(log: Log) -> int:
    """Number of ticks in a log; of its scenario if the log has no end, or none that can be true."""
    ticks = (log.summary or {}).get("ticks")
    return ticks if isinstance(ticks, int) and 0 < ticks <= log.scenario.ticks else log.scenario.ticks
