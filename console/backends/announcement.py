"""The first lines of fes run, printed before the run starts."""

from console.backends.processes import Launch
from console.connect import run_directory
from console.keys import stale_keys
from fes import process
from world.config import remarks
from world.config.scenario import Scenario


def announce(scenario: Scenario, in_process: bool, launch: Launch) -> None:
    """Print the size of the run, the parts of the scenario that do not run as written, and the stale keys removed."""
    robots = scenario.robots.number
    team = f"a world and {robots} robot{'s' if robots > 1 else ''}"
    groups = len(launch.groups(robots))
    crews = f" in {groups} process{'es' if groups > 1 else ''}" if launch.agents_per_process > 1 else ""
    process.tell(f"running {team} in one loop ..." if in_process else f"starting {team}{crews} ...")
    for line in remarks.of(scenario):
        process.warn("fes", line)
    for path in stale_keys.remove(run_directory.ROOT):
        process.warn("fes", f"removed {path}: private keys of a run that was killed")
