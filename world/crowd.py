"""What robots that start within range of each other need: memory for each contact, of which n of them have n^2."""

from fes import memory
from fes.errors import ScenarioError
from world import proximity
from world.scenario import Scenario, initial_poses

PER_CONTACT = 1_000
"""Memory that a run in one loop needs for each contact (receiver, sender) of a large crowd, log and summary included
[bytes]; `python -m bench.crowd` measures it. Of a small one it is more, by the radio's numbers: 128 MB at most."""


def check(scenario: Scenario) -> None:
    """Raise ScenarioError if the contacts at the start need more memory than there is."""
    free = memory.available()
    most, robots = free // PER_CONTACT, scenario.robots.number
    if robots * (robots - 1) <= most:
        return
    contacts = proximity.count(initial_poses(scenario), scenario.channel.communication_range, most)
    if contacts > most:
        needed = memory.gigabytes(PER_CONTACT * contacts)
        raise ScenarioError(
            "robots",
            f"the memory of {contacts:,} contacts at the start must be at most the {memory.gigabytes(free)} that are "
            f"free, got {needed}: start fewer robots, or farther apart (spacing)",
        )
