"""The first lines of fes run, before it starts anything."""

from console.backends.processes import Launch
from console.connect import run_directory
from console.keys import stale_keys
from fes import process
from world.config import remarks
from world.config.scenario import Scenario


def say(scenario: Scenario, in_process: bool, launch: Launch) -> None:
    """Print what is started, which parts of the scenario do not run as written, and which keys were removed."""
    robots = scenario.robots.number
    what = f"a world and {robots} robot{'s' if robots > 1 else ''}"
    groups = len(launch.groups(robots))
    crews = f" in {groups} process{'es' if groups > 1 else ''}" if launch.agents_per_process > 1 else ""
    process.tell(f"running {what} in one loop ..." if in_process else f"starting {what}{crews} ...")
    for line in remarks.of(scenario):
        process.warn("fes", line)
    for path in stale_keys.remove(run_directory.ROOT):
        process.warn("fes", f"removed {path}: private keys of a run that was killed")
