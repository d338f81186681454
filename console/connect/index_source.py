"""The source of the performance index, in the words of the glossary."""

import contextlib
from pathlib import Path

from console.connect import run_directory
from console.connect.run_directory import SCENARIO
from fes.errors import FesError
from fes.model.table import Use
from fes.transport.endpoints import Endpoints
from world.config.scenario import Scenario, knows_channel, load


def of(scenario: Scenario) -> str:
    """The source in a scenario: `oracle`, `measured`, `sampled`, or that it is up to another law."""
    if isinstance(scenario.seeking, Use):
        return "law told the channel" if knows_channel(scenario) else "own law"
    return scenario.seeking.index


def of_running(run: str, endpoints: Endpoints) -> str:
    """The source in the scenario of a run that was started in this folder; empty if the run is another one."""
    started = started_here(run, endpoints)
    return of(started[1]) if started is not None else ""


def started_here(run: str, endpoints: Endpoints) -> tuple[Path, Scenario] | None:
    """The directory and the scenario of the run at these endpoints; None unless it was started in this folder."""
    announcement = run_directory.announced(run)
    if announcement is None or announcement[1].endpoint not in endpoints.connect:
        return None
    directory = announcement[0].parent
    with contextlib.suppress(FesError, OSError):
        return directory, load(directory / SCENARIO[0])
    return None
