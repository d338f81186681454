"""The memory of contacts, of which n robots can have n^2."""

from fes.arrays.types import Floats
from fes.errors import ScenarioError
from fes.system import memory
from world.config.scenario import Scenario, initial_poses
from world.simulation import neighbor_list

PER_CONTACT = 1_000
"""Memory that a run in one loop needs per contact (receiver, sender) of a large crowd, log and summary included
[bytes]; `python -m bench.size.crowd` measures it. A small crowd needs up to 128 MB more, for the radio's numbers."""


def check(scenario: Scenario) -> None:
    """Raise ScenarioError if the contacts at the start need too much memory at the largest scheduled range."""
    if scenario.robots.number * scenario.robots.number > memory.available() // PER_CONTACT:
        fields = [settings.get("channel.communication_range") for settings in scenario.changes.values()]
        ranges = [scenario.channel.communication_range, *(field for field in fields if field is not None)]
        check_contacts(initial_poses(scenario), max(ranges))


def check_contacts(poses: Floats, reach: float) -> None:
    """Raise ScenarioError if the contacts of robots at `poses` [n, 3] within `reach` [m] need too much memory."""
    free, robots = memory.available(), len(poses)
    most = free // PER_CONTACT
    if robots * (robots - 1) <= most:
        return
    contacts = neighbor_list.count(poses, reach, most)
    if contacts > most:
        needed = memory.gigabytes(PER_CONTACT * contacts)
        raise ScenarioError(
            "robots",
            f"the memory of the {contacts:,} contacts within {reach:g} m must be at most the "
            f"{memory.gigabytes(free)} that are free, got {needed}: use fewer robots, or a larger spacing",
        )
